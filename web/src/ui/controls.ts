// The bar under the scene: play, time, speed, and how the scene is seen.

import { SPEEDS, type Player } from "../player";
import type { Cameras, View } from "../stage/cameras";
import { icon, make } from "./dom";
import type { Timeline } from "./timeline";
import { clock } from "./words";

export interface Shown {
  trail: boolean;
  forces: boolean;
}

const VIEWS: [View, string, string][] = [
  ["all", "All", "0"],
  ["corner", "Corner", "1"], ["side", "Side", "2"], ["front", "Front", "3"], ["top", "Top", "4"],
];

export class Controls {
  readonly element = make("div", { class: "controls", role: "group", "aria-label": "Playback" });
  readonly views = make("div", { class: "views", role: "group", "aria-label": "Camera" });
  private readonly play = make("button", { type: "button", class: "play" });
  private readonly time = make("span", { class: "time" });
  private readonly speed = make("select", { "aria-label": "Speed" });
  private readonly loop = this.toggle("Loop", "L", () => this.player.setLooping(!this.player.looping));
  private readonly follow = this.toggle("Follow", "F", () => this.switchFollow());
  private readonly trail = this.toggle("Trail", "T", () => this.switchShown("trail"));
  private readonly forces = this.toggle("Forces", "G", () => this.switchShown("forces"));
  private readonly buttons = new Map<View, HTMLButtonElement>();
  readonly shown: Shown = { trail: true, forces: true };

  constructor(
    private readonly player: Player,
    timeline: Timeline,
    private readonly cameras: () => Cameras | null,
    private readonly showing: (shown: Shown) => void,
    several: boolean,
    help: () => void,
  ) {
    this.play.addEventListener("click", () => player.toggle());
    for (const speed of SPEEDS) {
      this.speed.append(make("option", { value: String(speed) }, `${speed}×`));
    }
    this.speed.title = "Speed, [ and ]";
    this.speed.addEventListener("change", () => player.setSpeed(Number(this.speed.value)));
    const asked = make("button", { type: "button", class: "quiet", title: "Keys and about, ?", "aria-label": "Keys and about" }, icon("help"));
    asked.addEventListener("click", help);
    this.element.append(this.play, this.time, timeline.element, this.speed, this.loop, asked);
    const angles = make("div", { class: "segments" });
    for (const [view, name, key] of VIEWS) {
      if (view === "all" && !several) continue;
      const button = make("button", { type: "button", title: `${name} camera, ${key}` }, name);
      button.addEventListener("click", () => this.look(view));
      this.buttons.set(view, button);
      angles.append(button);
    }
    this.views.append(angles, make("div", { class: "segments" }, this.follow, this.trail, this.forces));
    player.onChange(() => this.update());
    this.update();
  }

  look(view: View): void {
    this.cameras()?.look(view);
    this.update();
  }

  switchFollow(): void {
    const cameras = this.cameras();
    if (cameras) cameras.following = !cameras.following;
    this.update();
  }

  switchShown(name: keyof Shown): void {
    this.shown[name] = !this.shown[name];
    this.showing(this.shown);
    this.update();
  }

  show(time: number): void {
    this.time.textContent = clock(time);
  }

  update(): void {
    const { playing, looping, speed } = this.player;
    this.play.replaceChildren(icon(playing ? "pause" : "play"));
    this.play.setAttribute("aria-label", playing ? "Pause" : "Play");
    this.play.title = `${playing ? "Pause" : "Play"}, space`;
    this.speed.value = String(speed);
    const cameras = this.cameras();
    press(this.loop, looping);
    press(this.follow, cameras?.following ?? true);
    press(this.trail, this.shown.trail);
    press(this.forces, this.shown.forces);
    for (const [view, button] of this.buttons) press(button, cameras?.view === view);
  }

  private toggle(name: string, key: string, act: () => void): HTMLButtonElement {
    const button = make("button", { type: "button", title: `${name}, ${key}` }, name);
    button.addEventListener("click", act);
    return button;
  }
}

function press(button: HTMLButtonElement, pressed: boolean): void {
  button.setAttribute("aria-pressed", String(pressed));
}
