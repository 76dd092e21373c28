// Draws less where a device cannot keep up: fewer pixels first, then no shadows.

const LEVELS = [
  { pixels: 2, shadows: true },
  { pixels: 1.5, shadows: true },
  { pixels: 1, shadows: true },
  { pixels: 1, shadows: false },
  { pixels: 0.6, shadows: false },
];
const SLOW = 1 / 40; // s a frame
const PATIENCE = 1.5; // s, after which fewer frames will do
const FRAMES = 24; // over which frames are averaged, so that one hitch counts for little

export class Quality {
  private level = 0;
  private seconds = 0;
  private frames = 0;

  /** Counts a frame that was drawn right after another; returns whether to draw less from now on. */
  count(seconds: number): boolean {
    this.seconds += seconds;
    if (++this.frames < FRAMES && this.seconds < PATIENCE) return false;
    const slow = this.seconds / this.frames > SLOW;
    this.seconds = this.frames = 0;
    if (!slow || this.level === LEVELS.length - 1) return false;
    this.level++;
    return true;
  }

  get pixels(): number {
    return Math.min(devicePixelRatio, LEVELS[this.level]!.pixels);
  }

  get shadows(): boolean {
    return LEVELS[this.level]!.shadows;
  }
}
