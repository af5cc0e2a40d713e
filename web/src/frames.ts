import { signal } from "@preact/signals";
import type { Frame } from "./messages";

/** A frame, and when it arrived [ms, performance.now()]. */
export interface TimedFrame {
  readonly frame: Frame;
  readonly arrival: number;
}

/**
 * The newest frames as they arrive.  They arrive sixty times a second, so they are no signal: the scene
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

/** What the page shows: the frames as they arrive, or one of the past. */
class ShownFrames {
  /** Whether the page shows the past while new frames arrive. */
  readonly isPast = signal(false);
  private past: TimedFrame[] = [];
  private readonly listeners = new Set<(frame: Frame) => void>();

  constructor(private readonly source: FrameBuffer) {
    source.listen((frame) => {
      if (!this.isPast.peek()) this.announce(frame);
    });
  }

  get latest(): Frame | undefined {
    return this.last.at(-1)?.frame;
  }

  get last(): readonly TimedFrame[] {
    return this.isPast.peek() ? this.past : this.source.last;
  }

  /** Show a frame of the past from now on; null: what arrives. */
  show(frame: Frame | null): void {
    this.past = frame === null ? [] : [{ frame, arrival: performance.now() }];
    this.isPast.value = frame !== null;
    const now = this.latest;
    if (now) this.announce(now);
  }

  /** Call `listener` with every frame to show; call the result to end it. */
  listen(listener: (frame: Frame) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  private announce(frame: Frame): void {
    for (const listener of this.listeners) listener(frame);
  }
}

export const shown = new ShownFrames(frames);
