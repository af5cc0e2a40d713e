/** The lines that uPlot draws, taken from a recording. */
import type { JointInfo } from "../protocol";
import type { Plotted, Scale } from "./quantities";
import type { Quantity, Recording } from "./recording";

/** A joint that is plotted. */
export interface Line {
  readonly joint: JointInfo;
  /** Its place in the arrays of a frame. */
  readonly index: number;
  /** Number of its colour. */
  readonly colour: number;
  readonly scale: Scale;
}

/** Return which quantities of a joint are drawn, the last of them solid. */
export function strokesOf(plotted: Plotted): readonly Quantity[] {
  return plotted === "position" ? ["desired", "position"] : [plotted];
}

export type Table = [number[], ...(number | null)[][]];

/** Return times and then one row for each stroke of each line, from time `from` on [s]. */
export function tableOf(
  recording: Recording,
  lines: readonly Line[],
  plotted: Plotted,
  from: number,
): Table {
  const first = recording.firstAt(from);
  const times: number[] = [];
  for (let i = first; i < recording.length; i++) times.push(recording.time(i));
  const rows: (number | null)[][] = [];
  for (const { index, scale } of lines) {
    for (const quantity of strokesOf(plotted)) {
      const row: (number | null)[] = [];
      for (let i = first; i < recording.length; i++) {
        const value = recording.value(quantity, index, i);
        row.push(Number.isNaN(value) ? null : value * scale.factor);
      }
      rows.push(row);
    }
  }
  return [times, ...rows];
}
