// Time: where it stands, how fast it goes, and who wants to know.

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

export class Player {
  time = 0;
  playing = false;
  looping = true;
  speed = 1;
  private readonly watchers: (() => void)[] = [];

  constructor(public duration: number) {}

  /** Calls a function whenever anything but the time has changed. */
  onChange(watcher: () => void): void {
    this.watchers.push(watcher);
  }

  /** Moves time on by the seconds that passed. */
  advance(seconds: number): void {
    if (!this.playing) return;
    this.time += seconds * this.speed;
    if (this.time < this.duration) return;
    if (this.looping) {
      // A moment to see how it ended.
      if (this.time >= this.duration + 1.2 * this.speed) this.time = 0;
    } else {
      this.time = this.duration;
      this.pause();
    }
  }

  /** The time to show. */
  get now(): number {
    return Math.min(this.time, this.duration);
  }

  play(): void {
    if (this.time >= this.duration) this.time = 0;
    this.playing = true;
    this.tell();
  }

  pause(): void {
    this.playing = false;
    this.time = this.now;
    this.tell();
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  seek(time: number): void {
    this.time = Math.min(Math.max(time, 0), this.duration);
    this.tell();
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    this.tell();
  }

  /** Takes the next speed up or down. */
  shift(by: number): void {
    const place = SPEEDS.indexOf(this.speed) + by;
    this.setSpeed(SPEEDS[Math.min(Math.max(place, 0), SPEEDS.length - 1)]!);
  }

  setLooping(looping: boolean): void {
    this.looping = looping;
    this.tell();
  }

  private tell(): void {
    for (const watcher of this.watchers) watcher();
  }
}
