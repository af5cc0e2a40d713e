/** The path that a point has moved along in the last seconds.  Pure. */
import type { Vector } from "../urdf";

/** Length of the trace [simulated s]. */
export const LASTS = 10;
/** A point closer to the last one is left out [m]. */
const APART = 0.002;
const MOST = 1000;

export class Trace {
  private times: number[] = [];
  private points: number[] = [];

  /** Take where the point is; return whether the trace is another now. */
  push(time: number, [x, y, z]: Vector): boolean {
    const last = this.times.at(-1);
    // after a reset
    if (last !== undefined && time < last) this.clear();
    const dropped = this.drop(time - LASTS);
    const { points } = this;
    const at = points.length - 3;
    const distance =
      at < 0
        ? Infinity
        : Math.hypot(
            x - (points[at] ?? 0),
            y - (points[at + 1] ?? 0),
            z - (points[at + 2] ?? 0),
          );
    if (distance < APART) return dropped;
    this.times.push(time);
    points.push(x, y, z);
    return true;
  }

  /** x y z of each point, the oldest first [m]. */
  get path(): readonly number[] {
    return this.points;
  }

  clear(): void {
    this.times = [];
    this.points = [];
  }

  private drop(before: number): boolean {
    const first = this.times.findIndex((time) => time >= before);
    const old = first < 0 ? this.times.length : first;
    const count = Math.max(old, this.times.length + 1 - MOST);
    this.times.splice(0, count);
    this.points.splice(0, 3 * count);
    return count > 0;
  }
}
