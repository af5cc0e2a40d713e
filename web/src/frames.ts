import type { Frame } from "./protocol";

/** A frame, and when it arrived [ms, performance.now()]. */
export interface TimedFrame {
  readonly frame: Frame;
  readonly arrival: number;
}

/**
 * The newest frames.  They arrive sixty times a second, so they are no signal: the scene
 * reads them at the display's rate, the plots listen.
 */
class FrameBuffer {
  private readonly recent: TimedFrame[] = [];
  private readonly listeners = new Set<(frame: Frame) => void>();

  get latest(): Frame | undefined {
    return this.recent.at(-1)?.frame;
  }

  /** The last frames, oldest first: enough to interpolate between. */
  get last(): readonly TimedFrame[] {
    return this.recent;
  }

  push(frame: Frame, arrival: number = performance.now()): void {
    this.recent.push({ frame, arrival });
    if (this.recent.length > 4) this.recent.shift();
    for (const listener of this.listeners) listener(frame);
  }

  /** Call `listener` with every frame; call the result to end it. */
  listen(listener: (frame: Frame) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  clear(): void {
    this.recent.length = 0;
  }
}

export const frames = new FrameBuffer();
