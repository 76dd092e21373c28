// Puts a replay together: data, time, scene and everything around it.

import { Motion } from "./motion";
import { Player } from "./player";
import type { Show } from "./show";
import { placesOf } from "./skeleton";
import { Stage } from "./stage/stage";
import { Controls } from "./ui/controls";
import { make } from "./ui/dom";
import { helpPage, listen } from "./ui/keyboard";
import { Numbers } from "./ui/numbers";
import { Plots } from "./ui/plots";
import { Timeline } from "./ui/timeline";
import { unpack, unzip } from "./unpack";

const WITHOUT_GL = "This browser draws no 3D (WebGL 2 is off or missing). The plots and numbers work without it.";

export class App {
  private readonly player: Player;
  private readonly motions: Motion[];
  private readonly stage: Stage | null;
  private readonly controls: Controls;
  private readonly timeline: Timeline;
  private readonly plots: Plots;
  private readonly numbers: Numbers;
  private chosen = 0;
  private before = 0;
  private drawn = NaN;
  private gone = false;
  private readonly quit = new AbortController();
  private readonly made: HTMLElement[];

  constructor(
    private readonly place: HTMLElement,
    private readonly show: Show,
    bytes: Uint8Array,
  ) {
    const read = (name: string) => unpack(bytes, show.series[name]!);
    this.motions = show.walkers.map((walker, index) => new Motion(
      walker, read(`walker ${index} moves`), read(`walker ${index} torques`),
      read(`walker ${index} pushes`), show.frame_s,
    ));
    this.player = new Player(Math.max(...this.motions.map((motion) => motion.duration)));
    const alone = place.dataset["layout"] === "page";
    const help = helpPage(place.dataset["version"] ?? "");
    const choose = (walker: number) => this.choose(walker);
    this.timeline = new Timeline(this.player, show.body.points);
    this.plots = new Plots(show, this.player, alone ? "h2" : "h4");
    this.numbers = new Numbers(show, choose);
    this.controls = new Controls(
      this.player, this.timeline, () => this.stage?.cameras ?? null,
      ({ trail, forces }) => {
        if (!this.stage) return;
        this.stage.showsTrail = trail;
        this.stage.showsForces = forces;
      },
      this.motions.length > 1,
      () => help.showModal(),
    );
    const title = make("header", {}, make(alone ? "h1" : "h3", {}, show.title), make("p", {}, show.what));
    const scene = make("div", { class: "scene" });
    const stage = make("div", { class: "stage" }, scene, title, this.numbers.live, this.controls.views);
    const panels = make("aside", { class: "panels" }, this.numbers.trial, this.plots.element);
    this.made = [stage, panels, this.controls.element, help];
    place.append(...this.made);
    this.stage = this.makeStage(scene, show, read("heights"), choose);
    this.controls.update();
    this.choose(0);
    listen(alone ? document : place, {
      player: this.player,
      controls: this.controls,
      frameSeconds: show.frame_s,
      turn: (by) => this.choose((this.chosen + by + this.motions.length) % this.motions.length),
      help: () => help.showModal(),
    }, this.quit.signal);
    matchMedia("(prefers-color-scheme: dark)").addEventListener(
      "change", () => this.paint(), { signal: this.quit.signal },
    );
    this.begin();
  }

  get time(): number {
    return this.player.now;
  }

  get playing(): boolean {
    return this.player.playing;
  }

  get walker(): number {
    return this.chosen;
  }

  /** Returns where each link of a walker is now, x, y and z, m. */
  links(walker: number): number[][] {
    return placesOf(this.show.body, this.motions[walker]!, this.time);
  }

  pause(): void {
    this.player.pause();
  }

  /** Takes everything off the page. */
  leave(): void {
    this.gone = true;
    this.quit.abort();
    this.stage?.dispose();
    for (const element of this.made) element.remove();
  }

  private begin(): void {
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (!calm && this.place.dataset["layout"] === "page") this.player.play();
    requestAnimationFrame((now) => this.frame(now));
    this.place.dataset["state"] = "ready";
  }

  private makeStage(
    scene: HTMLElement, show: Show, heights: Float32Array[], choose: (walker: number) => void,
  ): Stage | null {
    try {
      return new Stage(scene, show, this.motions, heights, () => this.controls.update(), choose);
    } catch (error) {
      console.warn(error);
      scene.append(make("p", { class: "sorry", role: "status" }, WITHOUT_GL));
      return null;
    }
  }

  private choose(walker: number): void {
    this.chosen = walker;
    const motion = this.motions[walker]!;
    this.stage?.choose(walker);
    this.timeline.choose(motion);
    this.plots.choose(motion);
    this.numbers.choose(walker, motion);
    this.drawn = NaN;
  }

  private paint(): void {
    this.stage?.paint();
    this.plots.paint();
    this.timeline.draw();
  }

  private frame(now: number): void {
    if (this.gone) return;
    // After a pause in another tab, time goes on where it stood.
    const passed = (now - this.before) / 1000;
    const seconds = Math.min(passed, 0.1);
    this.before = now;
    this.player.advance(seconds);
    const time = this.player.now;
    const jumped = Math.abs(time - this.drawn) > 1.5 * seconds * this.player.speed + 1e-6;
    this.stage?.draw(time, Math.min(passed, 2), jumped || Number.isNaN(this.drawn));
    if (time !== this.drawn) {
      this.timeline.show(time);
      this.controls.show(time);
      this.numbers.update(time);
      this.drawn = time;
    }
    this.plots.update(time);
    this.place.dataset["time"] = time.toFixed(3);
    requestAnimationFrame((later) => this.frame(later));
  }
}

/** Starts the replay that a place of the page holds. */
export async function mount(place: HTMLElement): Promise<App> {
  const text = (part: string) => place.querySelector(`[data-part=${part}]`)!.textContent!;
  const show = JSON.parse(text("show")) as Show;
  return new App(place, show, await unzip(text("series")));
}
