/** Draw on demand: a display frame is requested only while something moves. */

export interface Scenery {
  /** Bring everything to `now` [ms]; return whether it keeps moving by itself. */
  step: (now: number) => boolean;
  draw: () => void;
}

export class Loop {
  private request = 0;
  private dirty = false;
  private drawnAt = -Infinity;

  /** @param interval at least so long between drawings [ms] */
  constructor(
    private readonly scenery: Scenery,
    private readonly interval: number,
  ) {}

  /** Look whether something moves. */
  wake(): void {
    this.request ||= requestAnimationFrame(this.tick);
  }

  /** Something looks different: draw it. */
  invalidate(): void {
    this.dirty = true;
    this.wake();
  }

  stop(): void {
    cancelAnimationFrame(this.request);
    // nothing starts it again
    this.request = -1;
  }

  private readonly tick = (now: number): void => {
    this.request = 0;
    // a little early is not early: the display's own clock is uneven too
    const due = now - this.drawnAt > this.interval - 4;
    const moves = due ? this.scenery.step(now) : true;
    if (due && this.dirty) {
      this.dirty = false;
      this.drawnAt = now;
      this.scenery.draw();
    }
    if (moves || this.dirty) this.wake();
  };
}
