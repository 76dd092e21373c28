// What the walker has done so far, and what came out in the end.

import { Motion } from "../motion";
import type { Show } from "../show";
import { make } from "./dom";
import { number } from "./words";

const SPAN = 1; // s over which the speed of the moment is taken

export class Numbers {
  readonly live = make("div", { class: "live", "aria-hidden": "true" });
  readonly trial = make("section", { class: "trial", "aria-label": "The trial" });
  private readonly distance = make("span", { class: "figure" });
  private readonly speed = make("span", { class: "figure" });
  private readonly list = make("ul", { class: "walkers", "aria-label": "Walkers" });
  private readonly end = make("p", { class: "end" });
  private readonly table = make("dl");
  private motion: Motion | null = null;

  constructor(private readonly show: Show, choose: (walker: number) => void) {
    this.live.append(
      make("p", {}, this.distance, " m"), make("p", {}, this.speed, " m/s"),
    );
    if (show.walkers.length > 1) this.fill(choose);
    this.trial.append(this.end, this.table);
    if (show.walkers.length > 1) this.trial.append(this.list);
  }

  choose(walker: number, motion: Motion): void {
    this.motion = motion;
    const { figures, why, ending } = this.show.walkers[walker]!;
    this.end.textContent = why.charAt(0).toUpperCase() + why.slice(1);
    this.end.dataset["ending"] = ending;
    const rows: [string, string][] = [
      ["Distance", `${number(figures.distance_m, 1)} m`],
      ["Time", `${number(figures.duration_s, 1)} s`],
      ["Mean speed", `${number(figures.speed_m_s, 2)} m/s`],
      ["Cost of transport", number(figures.cost_of_transport, 2)],
      ...this.show.facts,
    ];
    this.table.replaceChildren(...rows.map(([name, value]) =>
      make("div", {}, make("dt", {}, name), make("dd", {}, value))));
    [...this.list.querySelectorAll("button")].forEach((button, index) => {
      button.setAttribute("aria-pressed", String(index === walker));
    });
  }

  update(time: number): void {
    const motion = this.motion;
    if (!motion) return;
    const x = motion.moves[0]!;
    const until = Math.min(time, motion.duration);
    const from = Math.max(until - SPAN, 0);
    const here = Motion.value(x, motion.at(until));
    const before = Motion.value(x, motion.at(from));
    this.distance.textContent = number(here, 1);
    this.speed.textContent = number(until > from ? (here - before) / (until - from) : 0, 1);
  }

  private fill(choose: (walker: number) => void): void {
    this.show.walkers.forEach((walker, index) => {
      const button = make("button", { type: "button", title: walker.why },
        make("span", { class: "dot", "data-ending": walker.ending }),
        make("span", {}, walker.label),
        make("span", { class: "far" }, `${number(walker.figures.distance_m, 1)} m`));
      button.addEventListener("click", () => choose(index));
      this.list.append(make("li", {}, button));
    });
  }
}
