/** A time line that can be played: the last minutes of a running robot, or a recording. */
import type { ReadonlySignal } from "@preact/signals";
import type { Marker } from "./markers";

export interface Range {
  readonly start: number;
  readonly end: number;
}

export interface Player {
  /** Whether its end moves on, with a robot that runs. */
  readonly isLive: boolean;
  readonly isPlaying: ReadonlySignal<boolean>;
  /** Seconds of the line per second of wall time. */
  readonly speed: ReadonlySignal<number>;
  /** Whether it starts again at its end; null: it has no end. */
  readonly loops: ReadonlySignal<boolean> | null;
  /** In their order on the line. */
  readonly markers: ReadonlySignal<readonly Marker[]>;
  /** The ends of the line [s]. */
  range(): Range;
  /** What is shown [s]. */
  position(): number;
  /** Show another instant [s]. */
  seek(at: number): void;
  play(isPlaying: boolean): void;
  setSpeed(speed: number): void;
  setLoops?(loops: boolean): void;
}
