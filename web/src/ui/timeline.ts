// The bar to scrub along, on which stands when each foot was on the ground.

import type { Motion } from "../motion";
import type { Player } from "../player";
import type { Point, Side } from "../show";
import { themeOf } from "../theme";
import { make } from "./dom";
import { clock } from "./words";

const STEP = 0.1; // s that an arrow key moves

export class Timeline {
  readonly element = make("div", { class: "timeline" });
  readonly range = make("input", { type: "range", min: "0", step: "0.01", "aria-label": "Time" });
  private readonly canvas = make("canvas", { "aria-hidden": "true" });
  private readonly head = make("div", { class: "head" });
  private motion: Motion | null = null;

  constructor(private readonly player: Player, private readonly points: Point[]) {
    this.range.max = String(player.duration);
    this.range.addEventListener("input", () => player.seek(Number(this.range.value)));
    this.range.addEventListener("keydown", (event) => {
      // Steps of our own, the same wherever the focus is.
      if (/^Arrow|^Home|^End|^Page/.test(event.key)) event.preventDefault();
    });
    this.element.append(this.canvas, this.head, this.range);
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  static step(large: boolean): number {
    return large ? 10 * STEP : STEP;
  }

  choose(motion: Motion): void {
    this.motion = motion;
    this.draw();
  }

  show(time: number): void {
    const share = this.player.duration ? time / this.player.duration : 0;
    this.head.style.left = `${(100 * share).toFixed(3)}%`;
    if (document.activeElement !== this.range || this.player.playing) {
      this.range.value = String(time);
    }
    this.range.setAttribute("aria-valuetext", `${clock(time)} of ${clock(this.player.duration)}`);
  }

  draw(): void {
    const motion = this.motion;
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!motion || !width) return;
    const scale = Math.min(devicePixelRatio, 2);
    [this.canvas.width, this.canvas.height] = [width * scale, height * scale];
    const pen = this.canvas.getContext("2d")!;
    pen.scale(scale, scale);
    const theme = themeOf(this.element);
    const row = (height - 3) / 2;
    (["left", "right"] as Side[]).forEach((side, index) => {
      pen.fillStyle = theme[side];
      const contact = motion.contact(this.points, side);
      const x = (frame: number) => (motion.times[frame]! / this.player.duration) * width;
      let start = -1;
      for (let frame = 0; frame <= contact.length; frame++) {
        const on = frame < contact.length && contact[frame] === 1;
        if (on && start < 0) start = frame;
        if (on || start < 0) continue;
        const end = Math.min(frame, contact.length - 1);
        pen.fillRect(x(start), index * (row + 3), Math.max(x(end) - x(start), 0.5), row);
        start = -1;
      }
    });
    pen.fillStyle = theme.line;
    const end = (motion.duration / this.player.duration) * width;
    if (end < width - 1) pen.fillRect(end, height / 2 - 0.5, width - end, 1);
  }
}
