/** Frames of the browser, requested only while something changes. */

export class FrameLoop {
  private request = 0;
  private before = 0;

  /** `draw` gets the seconds since the last frame of an unbroken run, and returns whether to go on. */
  constructor(private readonly draw: (seconds: number, now: number) => boolean) {}

  get idle(): boolean {
    return this.request === 0;
  }

  wake(): void {
    if (this.request === 0) this.request = requestAnimationFrame(this.frame);
  }

  stop(): void {
    cancelAnimationFrame(this.request);
    this.request = 0;
    this.before = 0;
  }

  private readonly frame = (now: number): void => {
    // a page that was hidden does not leap when it is seen again
    const seconds = this.before === 0 ? 0 : Math.min((now - this.before) / 1000, 0.1);
    this.request = 0;
    const more = this.draw(seconds, now);
    this.before = more ? now : 0;
    if (more) this.wake();
  };
}
