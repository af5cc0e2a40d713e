/** The last minute of every joint, in ring buffers. */
import type { Frame } from "../protocol";

/** Length of the recording [simulated s]. */
export const SPAN = 60;
const CAPACITY = 4096;

export type Field = "position" | "desired" | "velocity" | "effort";
const FIELDS: readonly Field[] = ["position", "desired", "velocity", "effort"];
export type Quantity = "position" | "desired" | "error" | "velocity" | "effort";

export class Recording {
  private readonly times: Float64Array;
  private readonly fields: Record<Field, Float64Array>;
  /** Where the oldest sample is. */
  private start = 0;
  private count = 0;

  constructor(
    readonly joints: number,
    private readonly capacity: number = CAPACITY,
    private readonly span: number = SPAN,
  ) {
    this.times = new Float64Array(capacity);
    const field = () => new Float64Array(capacity * joints);
    this.fields = {
      position: field(),
      desired: field(),
      velocity: field(),
      effort: field(),
    };
  }

  get length(): number {
    return this.count;
  }

  /** Simulated time of a sample, 0 being the oldest [s]. */
  time(index: number): number {
    return this.times[this.place(index)] ?? NaN;
  }

  /** Values of a joint at a sample; `error` is desired minus position; NaN: not known. */
  value(quantity: Quantity, joint: number, index: number): number {
    const at = this.place(index) * this.joints + joint;
    if (quantity !== "error") return this.fields[quantity][at] ?? NaN;
    return (this.fields.desired[at] ?? NaN) - (this.fields.position[at] ?? NaN);
  }

  /** Return the index of the first sample at `time` or later [s]. */
  firstAt(time: number): number {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  push(frame: Frame): void {
    if (this.count > 0 && frame.time < this.time(this.count - 1)) this.clear();
    const place = this.room(frame.time);
    this.times[place] = frame.time;
    for (const field of FIELDS) {
      const values = this.fields[field];
      const from = frame[field];
      for (let joint = 0; joint < this.joints; joint++) {
        values[place * this.joints + joint] = from[joint] ?? NaN;
      }
    }
  }

  clear(): void {
    this.start = this.count = 0;
  }

  /** Return a copy that no longer changes. */
  copy(): Recording {
    const copy = new Recording(this.joints, this.capacity, this.span);
    copy.times.set(this.times);
    for (const field of FIELDS) copy.fields[field].set(this.fields[field]);
    copy.start = this.start;
    copy.count = this.count;
    return copy;
  }

  private place(index: number): number {
    return (this.start + index) % this.capacity;
  }

  /**
   * Return where to write a sample at `time`: a new place, or that of the newest where
   * the samples come so densely (in slow motion) that the span would not fit.
   */
  private room(time: number): number {
    const { count } = this;
    const dense = (0.95 * this.span) / this.capacity;
    const before = count > 1 ? this.time(count - 2) : -Infinity;
    const paused = count > 0 && time === this.time(count - 1);
    if (paused || (count > 1 && time - before < dense)) return this.place(count - 1);
    if (count === this.capacity) this.start = this.place(1);
    else this.count += 1;
    return this.place(this.count - 1);
  }
}
