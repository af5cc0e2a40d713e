/** The last minutes of what the server sent, in a ring. */
import type { Frame } from "../messages";
import type { Status, ViewScene } from "../protocol";

/** Length of the history [simulated s]. */
export const SPAN = 300;
/** Frames at sixty a second for as long. */
const CAPACITY = 18_900;

/** What was known when a frame arrived. */
export interface Moment {
  readonly frame: Frame;
  readonly status: Status | null;
  readonly scene: ViewScene | null;
}

export class History {
  private moments: Moment[] = [];
  /** Where the oldest is. */
  private start = 0;

  constructor(
    readonly capacity: number = CAPACITY,
    private readonly span: number = SPAN,
  ) {}

  get length(): number {
    return this.moments.length;
  }

  /** Return where a moment is kept; 0 is the oldest. */
  place(index: number): number {
    return (this.start + index) % this.capacity;
  }

  at(index: number): Moment | undefined {
    return this.moments[this.place(index)];
  }

  /** Simulated time of a moment [s]. */
  time(index: number): number {
    return this.at(index)?.frame.time ?? NaN;
  }

  /** Return the index of the first moment at `time` or later [s]. */
  firstAt(time: number): number {
    let low = 0;
    let high = this.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** Keep a moment, and return its place. */
  push(moment: Moment): number {
    if (this.length > 0 && moment.frame.time < this.time(this.length - 1)) this.clear();
    const place = this.room(moment.frame.time);
    this.moments[place] = moment;
    return place;
  }

  clear(): void {
    this.moments = [];
    this.start = 0;
  }

  /** Return a copy that no longer changes. */
  copy(): History {
    const copy = new History(this.capacity, this.span);
    copy.moments = [...this.moments];
    copy.start = this.start;
    return copy;
  }

  /**
   * Return where to keep a moment at `time`: a new place, or that of the newest where
   * they come so densely (in slow motion) that the span would not fit.
   */
  private room(time: number): number {
    const count = this.length;
    const dense = (0.95 * this.span) / this.capacity;
    const before = count > 1 ? this.time(count - 2) : -Infinity;
    const isPaused = count > 0 && time === this.time(count - 1);
    if (isPaused || (count > 1 && time - before < dense)) return this.place(count - 1);
    if (count < this.capacity) return count;
    this.start = this.place(1);
    return this.place(count - 1);
  }
}
