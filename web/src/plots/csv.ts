/** Samples as a table, in SI units and with every digit. */
import { siUnit } from "./quantities";
import type { Samples, SignalInfo } from "./signals";

/** Names may contain any character; the table must stay valid. */
function quoted(text: string): string {
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** Return the name of a signal in files. */
function columnName({ of, quantity, kind }: SignalInfo): string {
  const name = of === "" ? quantity : `${of}.${quantity}`;
  return quoted(`${name} [${siUnit(kind)}]`);
}

/** Return `samples` of these signals; cells without a value are empty. */
export function csvOf(samples: Samples, signals: readonly SignalInfo[]): string {
  const { times, values } = samples;
  const lines = [["time [s]", ...signals.map(columnName)].join(",")];
  times.forEach((time, i) => {
    const cells = values.map((row) => row[i] ?? "");
    lines.push([time, ...cells].join(","));
  });
  return lines.join("\n") + "\n";
}
