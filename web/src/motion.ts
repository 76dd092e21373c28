// How one walker moves: its frames, and what lies between two of them.

import type { Point, Side, Walker } from "./show";

export interface Moment {
  frame: number;
  fraction: number;
}

export class Motion {
  readonly times: Float64Array;
  readonly duration: number;

  constructor(
    readonly walker: Walker,
    readonly moves: Float32Array[],
    readonly torques: Float32Array[],
    readonly pushes: Float32Array[],
    private readonly frameSeconds: number,
  ) {
    this.duration = walker.figures.duration_s;
    this.times = Float64Array.from({ length: walker.frames }, (_, frame) => frame * frameSeconds);
    // The frame in which a trial ends may come sooner than a whole frame.
    if (walker.frames > 1) this.times[walker.frames - 1] = this.duration;
  }

  /** Returns the frame before a time, and how far the time is on its way to the next. */
  at(time: number): Moment {
    const last = this.times.length - 1;
    if (last === 0 || time >= this.duration) return { frame: last, fraction: 0 };
    const frame = Math.min(Math.max(Math.floor(time / this.frameSeconds), 0), last - 1);
    const start = this.times[frame]!;
    const fraction = (time - start) / (this.times[frame + 1]! - start || 1);
    return { frame, fraction: Math.min(Math.max(fraction, 0), 1) };
  }

  /** Returns a channel's value at a moment. */
  static value(channel: Float32Array, { frame, fraction }: Moment): number {
    const before = channel[frame]!;
    return fraction === 0 ? before : before + fraction * (channel[frame + 1]! - before);
  }

  /** Writes all coordinates of a moment. */
  pose(moment: Moment, into: Float32Array): void {
    for (let index = 0; index < this.moves.length; index++) {
      into[index] = Motion.value(this.moves[index]!, moment);
    }
  }

  hasEnded(time: number): boolean {
    return time >= this.duration;
  }

  /** Returns whether a foot carries load, frame by frame. */
  contact(points: Point[], side: Side): Uint8Array {
    const found = new Uint8Array(this.times.length);
    points.forEach((point, index) => {
      if (point.side !== side) return;
      const normal = this.pushes[3 * index + 2]!;
      for (let frame = 0; frame < found.length; frame++) if (normal[frame]! > 0) found[frame] = 1;
    });
    return found;
  }

  /** Returns a foot's upward load, frame by frame, N. */
  load(points: Point[], side: Side): Float32Array {
    const found = new Float32Array(this.times.length);
    points.forEach((point, index) => {
      if (point.side !== side) return;
      const normal = this.pushes[3 * index + 2]!;
      for (let frame = 0; frame < found.length; frame++) found[frame]! += normal[frame]!;
    });
    return found;
  }
}
