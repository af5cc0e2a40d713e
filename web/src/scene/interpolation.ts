/**
 * Smooth motion between frames, at the display's rate.
 *
 * Frames come unevenly, while their simulated times are exact.  So a straight line is laid
 * through the last (arrival, time) pairs, and what is shown is where that line was one and
 * a half frames ago: there is then nearly always a frame before it and one after.
 */
import type { Frame } from "../messages";

/** How many frames the line is laid through: half a second. */
const HISTORY = 32;
/** After this long without a frame nothing is known about the way between [ms]. */
const GAP_MS = 400;
/** How far behind the newest frame is shown [frames]. */
const BEHIND = 1.5;
/** Numbers of an object's pose: x y z, and w x y z. */
const PER_OBJECT = 7;

interface Sample {
  /** Simulated [s]. */
  readonly time: number;
  /** [ms] */
  readonly arrival: number;
  /** Positions of the joints, then poses of the objects. */
  readonly values: Float64Array;
  /** Of which scene the objects are. */
  readonly scene: number;
  readonly joints: number;
}

/** What to draw at an instant. */
export interface Pose {
  /** Simulated [s]. */
  time: number;
  /** Positions of the joints [rad | m], then x y z w x y z of each object. */
  values: Float64Array;
  /** Of which scene the objects are. */
  scene: number;
}

/** Return the numbers of a frame, quaternions on the same side as in `before`. */
function flattened(frame: Frame, before: Sample | undefined): Float64Array {
  const previous = before?.scene === frame.scene_number ? before.values : undefined;
  const count = frame.position.length;
  const values = new Float64Array(count + frame.objects.length * PER_OBJECT);
  values.set(frame.position);
  frame.objects.forEach(([position, quaternion], index) => {
    const at = count + index * PER_OBJECT;
    values.set(position, at);
    values.set(quaternion, at + 3);
    if (previous?.length !== values.length) return;
    let dot = 0;
    for (let i = at + 3; i < at + PER_OBJECT; i++) {
      dot += (values[i] ?? 0) * (previous[i] ?? 0);
    }
    // q and -q are one rotation, but the way between them is not short
    if (dot < 0) {
      for (let i = at + 3; i < at + PER_OBJECT; i++) values[i] = -(values[i] ?? 0);
    }
  });
  return values;
}

export class Interpolator {
  private history: Sample[] = [];
  /** The line: `time = meanTime + rate * (arrival - meanArrival)`, rate in s per ms. */
  private rate = 1e-3;
  private meanTime = 0;
  private meanArrival = 0;
  /** Between frames [ms]. */
  private interval = 1000 / 60;
  private shown = -Infinity;

  /** Take a frame that arrived at `arrival` [ms]. */
  push(frame: Frame, arrival: number): void {
    const newest = this.history.at(-1);
    const values = flattened(frame, newest);
    const { time, scene_number: scene } = frame;
    const sample = { time, arrival, values, scene, joints: frame.position.length };
    if (newest?.time === frame.time) {
      // paused, or posed by hand: there is no time in which to move
      this.history[this.history.length - 1] = { ...sample, arrival: newest.arrival };
      return;
    }
    if (newest && (frame.time < newest.time || arrival - newest.arrival > GAP_MS)) {
      this.history = [];
      this.shown = -Infinity;
    }
    this.history.push(sample);
    if (this.history.length > HISTORY) this.history.shift();
    this.fit();
    if (Math.abs(this.timeAt(arrival) - frame.time) > 4 * this.interval * this.rate) {
      // another speed: the history no longer applies
      this.history = this.history.slice(-2);
      this.fit();
    }
  }

  /** Write into `pose` what to draw at `now` [ms]; return whether it will not change until a frame comes. */
  sample(now: number, pose: Pose): boolean {
    const oldest = this.history[0];
    const newest = this.history.at(-1);
    if (!oldest || !newest) return true;
    const wanted = Math.max(
      this.shown,
      this.timeAt(now - BEHIND * this.interval),
      oldest.time,
    );
    const time = Math.min(wanted, newest.time);
    this.shown = time;
    let after = this.history.length - 1;
    while (after > 0 && (this.history[after - 1]?.time ?? time) >= time) after--;
    const to = this.history[after] ?? newest;
    const from = this.history[after - 1] ?? to;
    const share = to === from ? 1 : (time - from.time) / (to.time - from.time);
    if (pose.values.length !== to.values.length) {
      pose.values = new Float64Array(to.values.length);
    }
    // objects of different scenes cannot be interpolated
    const moving = from.scene === to.scene ? to.values.length : to.joints;
    for (let i = 0; i < to.values.length; i++) {
      const a = from.values[i] ?? 0;
      const b = to.values[i] ?? 0;
      pose.values[i] = share === 1 || i >= moving ? b : a + share * (b - a);
    }
    pose.time = time;
    pose.scene = to.scene;
    return time >= newest.time;
  }

  private timeAt(arrival: number): number {
    return this.meanTime + this.rate * (arrival - this.meanArrival);
  }

  /** Lay the line through the history, by least squares. */
  private fit(): void {
    const count = this.history.length;
    let time = 0;
    let arrival = 0;
    for (const sample of this.history) {
      time += sample.time / count;
      arrival += sample.arrival / count;
    }
    let both = 0;
    let square = 0;
    for (const sample of this.history) {
      both += (sample.time - time) * (sample.arrival - arrival);
      square += (sample.arrival - arrival) ** 2;
    }
    this.meanTime = time;
    this.meanArrival = arrival;
    if (square < 1) return;
    this.rate = both / square;
    const first = this.history[0]?.arrival ?? 0;
    this.interval = ((this.history.at(-1)?.arrival ?? 0) - first) / (count - 1);
  }
}
