/** What can be plotted, and where its samples come from: a running robot or a recording. */
import { type ReadonlySignal, signal } from "@preact/signals";

/** What a signal measures; signals of one kind share an axis. */
export type Kind =
  | "angle" // [rad]
  | "length" // [m]
  | "angular-velocity" // [rad/s]
  | "velocity" // [m/s]
  | "torque" // [N·m]
  | "force" // [N]
  | "ratio"
  | "count";

/** The headings under which signals are chosen. */
export type Group =
  | "joint-position"
  | "joint-desired"
  | "joint-error"
  | "joint-velocity"
  | "joint-effort"
  | "tool"
  | "wrench"
  | "gripper"
  | "object"
  | "simulation";

export interface SignalInfo {
  /**
   * Unique, and the same at each visit: `joint/elbow_joint/position`,
   * `tool/arm/x`, `wrench/arm/fz`, `gripper/gripper/opening`, `object/cup/z`,
   * `simulation/real_time_factor`.  See `live.ts` for all of them.
   */
  readonly id: string;
  readonly group: Group;
  /** What it is of: a joint, an arm, a gripper, an object; "" for the simulation. */
  readonly of: string;
  /** Which value of it: `position`, `x`, `fz`, …  */
  readonly quantity: string;
  readonly kind: Kind;
  /** The signal that this one should follow, drawn dashed with it. */
  readonly desired?: string;
  /** Its value lies between this and its negative, as far as is known. */
  readonly limit?: number;
}

/** Samples of several signals at common times. */
export interface Samples {
  /** Ascending [s]. */
  readonly times: readonly number[];
  /** For each signal, a value in SI for each time; null: not known. */
  readonly values: readonly (readonly (number | null)[])[];
}

export interface SignalSource {
  /** All signals, by id; it changes with the robot and the objects. */
  readonly signals: ReadonlySignal<ReadonlyMap<string, SignalInfo>>;

  /** The times that have samples, first and last [s]; null: there are none yet. */
  span(): readonly [number, number] | null;

  /** The time that the page shows now [s]: the newest one, or that of the playhead. */
  now(): number;

  /** Have these signals sampled from now on; call the result to end it. */
  need(ids: readonly string[]): () => void;

  /**
   * Return what is known at once of some signals, in the order of `ids`.
   *
   * It includes the nearest sample on either side of `from` and `to` [s], so that a line
   * reaches the edge.  With more than `points` samples, consecutive ones are replaced
   * by their least and greatest, so that no peak is lost.  A source that has to fetch
   * samples returns those it has, and calls its listeners when there are more.
   */
  read(ids: readonly string[], from: number, to: number, points: number): Samples;

  /** Return all samples from `from` to `to` [s], none of them replaced. */
  exact(ids: readonly string[], from: number, to: number): Promise<Samples>;

  /** Call `listener` when `read` or `now` may have changed; call the result to end it. */
  listen(listener: () => void): () => void;

  /** Return a source that keeps the present samples; itself, if it never forgets any. */
  held(): SignalSource;
}

const NONE: SignalSource = {
  signals: signal(new Map()),
  span: () => null,
  now: () => 0,
  need: () => () => undefined,
  read: (ids) => ({ times: [], values: ids.map(() => []) }),
  exact: (ids) => Promise.resolve(NONE.read(ids, 0, 0, 0)),
  listen: () => () => undefined,
  held: () => NONE,
};

/** What the plots show: `live.ts` sets the running robot, a replay its recording. */
export const source = signal<SignalSource>(NONE);
