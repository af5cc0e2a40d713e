/** A recording as a table, in SI units and with every digit. */
import type { JointInfo } from "../protocol";
import { siUnit } from "./quantities";
import type { Quantity, Recording } from "./recording";

const COLUMNS: readonly Quantity[] = [
  "position",
  "desired",
  "error",
  "velocity",
  "effort",
];

export interface Column {
  /** Its place in the arrays of a frame. */
  readonly index: number;
  readonly joint: JointInfo;
}

/** Names may contain any character; the table must stay valid. */
function quoted(text: string): string {
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** Return the samples of `recording` from time `from` to `to` [s]. */
export function csvOf(
  recording: Recording,
  joints: readonly Column[],
  from: number,
  to: number,
): string {
  const header = ["time [s]"];
  for (const { joint } of joints) {
    for (const quantity of COLUMNS) {
      header.push(
        quoted(`${joint.name}.${quantity} [${siUnit(quantity, joint.type)}]`),
      );
    }
  }
  const lines = [header.join(",")];
  for (let i = recording.firstAt(from); i < recording.length; i++) {
    const time = recording.time(i);
    if (time > to) break;
    const cells = [String(time)];
    for (const { index } of joints) {
      for (const quantity of COLUMNS) {
        const value = recording.value(quantity, index, i);
        cells.push(Number.isFinite(value) ? String(value) : "");
      }
    }
    lines.push(cells.join(","));
  }
  return lines.join("\n") + "\n";
}
