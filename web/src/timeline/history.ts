/** The last minutes of frames, in bounded memory: what the page can scroll back to. */
import type { Frame } from "../messages";
import type { ViewScene } from "../protocol";

/** Length of the history [wall ms]. */
export const SPAN_MS = 300_000;
/** Frames nearer to each other are not kept [wall ms]: thirty-two a second are. */
const SPACING_MS = 1000 / 32;
/** Largest number of kept numbers: about 20 MB. */
const CAPACITY = 2_000_000;

/** A kept frame, and its place on the time line. */
export interface Moment {
  /**
   * Simulated time that had passed on this page [s]: unlike the frame's own time, it
   * continues when a reset sets that back.
   */
  readonly at: number;
  readonly arrival: number;
  readonly frame: Frame;
  readonly scene: ViewScene | null;
}

export class History {
  private moments: Moment[] = [];
  /** Where the oldest one is; those before it are dropped from time to time. */
  private first = 0;
  private numbers = 0;
  /** What is added to a frame's time. */
  private offset = 0;
  private newestTime = -Infinity;
  /** The place of the newest frame, also if it is not kept. */
  end = 0;

  constructor(
    private readonly span = SPAN_MS,
    private readonly capacity = CAPACITY,
  ) {}

  get start(): number {
    return this.moments[this.first]?.at ?? this.end;
  }

  get length(): number {
    return this.moments.length - this.first;
  }

  /** Return the place of a simulated time since the last reset. */
  placeOf(time: number): number {
    return time + this.offset;
  }

  push(frame: Frame, scene: ViewScene | null, arrival: number): void {
    if (this.length === 0) this.offset = 0;
    else if (frame.time < this.newestTime) this.offset += this.newestTime - frame.time;
    this.newestTime = frame.time;
    this.end = this.placeOf(frame.time);
    const before = this.moments[this.moments.length - 2];
    const newest = this.moments.at(-1);
    // the newest is always kept, until it turns out to be between two that are enough
    const isDense =
      newest?.at === this.end ||
      (before && newest && newest.arrival - before.arrival < SPACING_MS);
    if (isDense) this.dropNewest();
    this.moments.push({ at: this.end, arrival, frame, scene });
    this.numbers += sizeOf(frame);
    this.dropOldest(arrival);
  }

  /** Return what was at a place: the last moment before it, or the oldest. */
  moment(at: number): Moment | undefined {
    let low = this.first;
    let high = this.moments.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((this.moments[middle]?.at ?? Infinity) <= at) low = middle + 1;
      else high = middle;
    }
    return this.moments[Math.max(this.first, low - 1)];
  }

  clear(): void {
    this.moments = [];
    this.first = this.numbers = this.offset = this.end = 0;
    this.newestTime = -Infinity;
  }

  private dropNewest(): void {
    const dropped = this.moments.pop();
    if (dropped) this.numbers -= sizeOf(dropped.frame);
  }

  private dropOldest(now: number): void {
    for (;;) {
      const oldest = this.moments[this.first];
      if (!oldest || this.length < 3) break;
      if (now - oldest.arrival <= this.span && this.numbers <= this.capacity) break;
      this.numbers -= sizeOf(oldest.frame);
      this.first += 1;
    }
    if (this.first < 1000) return;
    this.moments = this.moments.slice(this.first);
    this.first = 0;
  }
}

/** Return about how many numbers a frame holds. */
function sizeOf(frame: Frame): number {
  return 4 * frame.position.length + 7 * frame.objects.length + 8;
}
