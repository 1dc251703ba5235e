/** The time of a player: it runs, loops and steps within the range of a source. */

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10] as const;

export class Clock {
  time: number;
  playing = false;
  speed = 1;
  loop = true;

  constructor(
    readonly start: number,
    readonly end: number,
  ) {
    this.time = start;
  }

  get duration(): number {
    return this.end - this.start;
  }

  play(): void {
    if (this.duration <= 0) return;
    if (this.time >= this.end) this.time = this.start;
    this.playing = true;
  }

  pause(): void {
    this.playing = false;
  }

  /** Set the time, held within the range. */
  seek(time: number): void {
    this.time = Math.min(this.end, Math.max(this.start, Number.isFinite(time) ? time : this.start));
  }

  /** Go on by so many seconds of the wall clock. */
  advance(seconds: number): void {
    if (!this.playing) return;
    const next = this.time + seconds * this.speed;
    if (next < this.end) {
      this.time = next;
    } else if (this.loop) {
      this.time = this.start + ((next - this.start) % this.duration);
    } else {
      this.time = this.end;
      this.playing = false;
    }
  }

  /** Choose the next speed of the list in a direction. */
  changeSpeed(direction: 1 | -1): void {
    const next = direction > 0
      ? SPEEDS.find((each) => each > this.speed)
      : [...SPEEDS].reverse().find((each) => each < this.speed);
    this.speed = next ?? this.speed;
  }
}
