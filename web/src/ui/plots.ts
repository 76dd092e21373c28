// Angles, torques and loads over time; the window moves along with the time cursor.

import uPlot from "uplot";
import { Motion } from "../motion";
import type { Player } from "../player";
import type { Angle, Show, Side } from "../show";
import { themeOf, type Theme } from "../theme";
import { make } from "./dom";
import { number } from "./words";

const WINDOW = 4; // s that a plot shows
const DEGREES = 180 / Math.PI;

interface Line {
  side: Side;
  values: (motion: Motion) => Float32Array;
}

interface Chart {
  title: string;
  unit: string;
  places: number;
  lines: Line[];
  reading: Map<Side, HTMLElement>;
  box: HTMLElement;
  cursor: HTMLElement;
  plot: uPlot | null;
  data: Float32Array[];
  inSight: boolean;
}

export class Plots {
  readonly element = make("section", { class: "plots", "aria-label": "Angles, torques and forces over time" });
  private readonly charts: Chart[] = [];
  private motion: Motion | null = null;
  private shown = NaN;

  constructor(show: Show, private readonly player: Player, private readonly level: "h2" | "h4") {
    const { angles, points } = show.body;
    const several = new Set(points.map((point) => point.leg)).size > 2;
    this.group("Joint angle", "°", 0, angles, (angle) => (motion) =>
      motion.moves[angle.coordinate]!.map((value) => value * DEGREES));
    this.group("Motor torque", "N m", 0, angles.filter((angle) => angle.motor !== null),
      (angle) => (motion) => motion.torques[angle.motor!]!);
    this.heading("Ground force", "body weights");
    const title = several ? "up on the feet of each side" : "up on each foot";
    this.chart(title, "", 2, (["left", "right"] as Side[]).map((side) => ({
      side,
      values: (motion) => motion.load(points, side).map((value) => value / show.weight_n),
    })));
    const watcher = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        const chart = this.charts.find(({ box }) => box === entry.target)!;
        chart.inSight = entry.isIntersecting;
        this.shown = NaN;
      }
    });
    for (const chart of this.charts) watcher.observe(chart.box);
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  choose(motion: Motion): void {
    this.motion = motion;
    for (const chart of this.charts) chart.data = chart.lines.map((line) => line.values(motion));
    this.paint();
  }

  /** Draws anew in the colours that hold now. */
  paint(): void {
    const motion = this.motion;
    if (!motion) return;
    const theme = themeOf(this.element);
    for (const chart of this.charts) {
      chart.plot?.destroy();
      chart.plot = this.plot(chart, motion, theme);
    }
    this.shown = NaN;
  }

  update(time: number): void {
    const motion = this.motion;
    if (!motion || time === this.shown) return;
    this.shown = time;
    const [from, to] = this.window(motion);
    const moment = motion.at(time);
    for (const chart of this.charts) {
      if (!chart.plot || !chart.inSight) continue;
      chart.plot.setScale("x", { min: from, max: to });
      const { left, width } = chart.plot.bbox;
      const x = left / devicePixelRatio
        + ((Math.min(time, motion.duration) - from) / (to - from)) * (width / devicePixelRatio);
      chart.cursor.style.transform = `translateX(${x.toFixed(1)}px)`;
      chart.lines.forEach((line, index) => {
        const value = Motion.value(chart.data[index]!, moment);
        chart.reading.get(line.side)!.textContent = `${number(value, chart.places)}${chart.unit}`;
      });
    }
  }

  private window(motion: Motion): [number, number] {
    const length = Math.min(WINDOW, Math.max(motion.duration, 0.1));
    const from = Math.min(Math.max(this.player.now - length / 2, 0), motion.duration - length);
    return [Math.max(from, 0), Math.max(from, 0) + length];
  }

  private group(
    title: string, unit: string, places: number, angles: Angle[],
    values: (angle: Angle) => Line["values"],
  ): void {
    this.heading(title, unit === "°" ? "degrees" : unit);
    for (const name of new Set(angles.map((angle) => angle.name))) {
      const lines = angles.filter((angle) => angle.name === name)
        .map((angle) => ({ side: angle.side, values: values(angle) }));
      this.chart(name, unit === "°" ? unit : "", places, lines);
    }
  }

  private heading(title: string, unit: string): void {
    this.element.append(make(this.level, {}, title, make("small", {}, ` ${unit}`)));
  }

  private chart(title: string, unit: string, places: number, lines: Line[]): void {
    const reading = new Map(lines.map(({ side }) => [side, make("span", { class: side })]));
    const cursor = make("div", { class: "cursor" });
    const box = make("div", { class: "chart" }, cursor);
    const legend = make("p", {}, make("b", {}, title), ...reading.values());
    this.element.append(make("div", { class: "panel" }, legend, box));
    this.charts.push({
      title, unit, places, lines, reading, box, cursor, plot: null, data: [], inSight: true,
    });
    const seek = (event: PointerEvent) => this.seek(event, box);
    box.addEventListener("pointerdown", (event) => {
      box.setPointerCapture(event.pointerId);
      this.player.pause();
      seek(event);
    });
    box.addEventListener("pointermove", (event) => {
      if (box.hasPointerCapture(event.pointerId)) this.drag(event, box);
    });
  }

  private seek(event: PointerEvent, box: HTMLElement): void {
    const chart = this.charts.find((each) => each.box === box)!;
    if (!chart.plot) return;
    const x = event.clientX - box.getBoundingClientRect().left - chart.plot.bbox.left / devicePixelRatio;
    this.player.seek(chart.plot.posToVal(x, "x"));
  }

  /** The plot is pulled along under the cursor. */
  private drag(event: PointerEvent, box: HTMLElement): void {
    this.player.seek(this.player.now - (event.movementX * WINDOW) / box.clientWidth);
  }

  private plot(chart: Chart, motion: Motion, theme: Theme): uPlot {
    const font = "11px system-ui, sans-serif";
    const axis = { stroke: theme.muted, font, grid: { stroke: theme.line, width: 1 }, ticks: { show: false } };
    const all = chart.data.flatMap((values) => [Math.min(...bounds(values)), Math.max(...bounds(values))]);
    const [low, high] = [Math.min(...all, 0), Math.max(...all, 0)];
    const room = 0.06 * (high - low || 1);
    const plot = new uPlot({
      width: chart.box.clientWidth || 320,
      height: chart.box.clientHeight || 76,
      padding: [4, 2, 0, 0],
      legend: { show: false },
      cursor: { show: false },
      scales: { x: { time: false }, y: { range: [low - room, high + room] } },
      axes: [
        { ...axis, size: 18, gap: 2, space: 44, values: (_, ticks) => ticks.map((tick) => `${tick} s`) },
        { ...axis, size: 36, gap: 4, space: 16, values: (_, ticks) => ticks.map((tick) => number(tick, Math.abs(high - low) < 3 ? 1 : 0)) },
      ],
      series: [{}, ...chart.lines.map((line) => ({
        stroke: line.side === "middle" ? theme.ink : theme[line.side], width: 1.6, points: { show: false },
      }))],
    }, [Array.from(motion.times), ...chart.data.map((values) => Array.from(values))], chart.box);
    return plot;
  }

  private resize(): void {
    for (const { plot, box } of this.charts) {
      if (plot && box.clientWidth) plot.setSize({ width: box.clientWidth, height: box.clientHeight });
    }
    this.shown = NaN;
  }
}

/** Returns what lies between the lowest and highest of nearly all values: impacts are brief. */
function bounds(values: Float32Array): [number, number] {
  const sorted = Float32Array.from(values).sort();
  const skipped = Math.floor(0.002 * sorted.length);
  return [sorted[skipped]!, sorted[sorted.length - 1 - skipped]!];
}
