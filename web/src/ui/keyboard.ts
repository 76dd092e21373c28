// Keys, and the page that tells of them.

import type { Player } from "../player";
import type { Controls } from "./controls";
import { make } from "./dom";
import { Timeline } from "./timeline";

declare const LICENCES: { name: string; licence: string }[];

const KEYS: [string, string][] = [
  ["Space", "play or pause"],
  ["\u2190 \u2192", "a tenth of a second back or on; with Shift a second"],
  [", .", "a frame back or on"],
  ["Home End", "first or last moment"],
  ["[ ]", "slower or faster"],
  ["1 2 3 4", "camera at the corner, the side, the front, the top; 0 sees all walkers"],
  ["F", "camera follows the walker or stays"],
  ["T G", "trail of stick figures, ground forces"],
  ["L", "play again at the end"],
  ["\u2191 \u2193", "next walker, where there are several"],
  ["?", "this page"],
];

export interface Targets {
  player: Player;
  controls: Controls;
  frameSeconds: number;
  turn: (by: number) => void;
  help: () => void;
}

/** Obeys keys that are pressed in a place. */
export function listen(place: HTMLElement | Document, targets: Targets, signal: AbortSignal): void {
  place.addEventListener("keydown", (event) => obey(event as KeyboardEvent, targets), { signal });
}

function obey(event: KeyboardEvent, { player, controls, frameSeconds, turn, help }: Targets): void {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const target = event.target as HTMLElement;
  if (target.closest("dialog") || target.matches("select, input:not([type=range])")) return;
  const frame = (by: number) => {
    player.pause();
    player.seek(player.now + by * frameSeconds);
  };
  const acts: Record<string, () => void> = {
    " ": () => player.toggle(),
    ArrowLeft: () => player.seek(player.now - Timeline.step(event.shiftKey)),
    ArrowRight: () => player.seek(player.now + Timeline.step(event.shiftKey)),
    ArrowUp: () => turn(-1),
    ArrowDown: () => turn(1),
    ",": () => frame(-1),
    ".": () => frame(1),
    Home: () => player.seek(0),
    End: () => player.seek(player.duration),
    "[": () => player.shift(-1),
    "]": () => player.shift(1),
    "0": () => controls.look("all"),
    "1": () => controls.look("corner"),
    "2": () => controls.look("side"),
    "3": () => controls.look("front"),
    "4": () => controls.look("top"),
    f: () => controls.switchFollow(),
    t: () => controls.switchShown("trail"),
    g: () => controls.switchShown("forces"),
    l: () => player.setLooping(!player.looping),
    "?": help,
  };
  const act = acts[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  // A button that has the focus takes the space bar itself.
  if (!act || (event.key === " " && target.matches("button"))) return;
  event.preventDefault();
  act();
}

/** Returns a dialog with the keys, and with what the page is made of. */
export function helpPage(version: string): HTMLDialogElement {
  const close = make("button", { type: "button", class: "close" }, "Close");
  const keys = make("dl", {}, ...KEYS.map(([key, what]) =>
    make("div", {}, make("dt", {}, ...key.split(" ").map((each) => make("kbd", {}, each))), make("dd", {}, what))));
  const about = make("details", {}, make("summary", {}, "Licences"),
    ...LICENCES.map(({ name, licence }) => make("section", {}, make("h3", {}, name), make("pre", {}, licence))));
  const dialog = make("dialog", { class: "help", "aria-labelledby": "help-title" },
    make("h2", { id: "help-title" }, "Keys"), keys,
    make("p", { class: "note" }, "Side by side, every walker has the same ground, and paths in space are laid straight."),
    make("p", { class: "note" }, `Recorded and made by mjxwalk ${version}, Apache-2.0; drawn with three.js and uPlot.`),
    about, close);
  close.addEventListener("click", () => dialog.close());
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });
  return dialog;
}
