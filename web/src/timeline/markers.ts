/** What happened, as marks on the time line. */
import type { Notice } from "../protocol";

export type MarkerKind = "goal" | "contact" | "warning" | "error" | "event";

export interface Marker {
  /** Its place on the time line [s]. */
  readonly at: number;
  readonly kind: MarkerKind;
  readonly text: string;
}

/** Marks nearer to each other than this share of the line are one. */
const MERGED = 0.006;
/** Most texts in one mark. */
const MOST_TEXTS = 8;
/** A jump goes at least so far [s]: a mark that is shown is not the next one. */
const REACHED = 0.03;
const ORDER: readonly MarkerKind[] = ["event", "goal", "contact", "warning", "error"];

/** Return how to mark a notice, or null for one that concerns no instant. */
export function kindOf({ code, severity, time }: Notice): MarkerKind | null {
  if (time === null || code === "lint" || code === "refused") return null;
  if (severity !== "info") return severity;
  if (code.startsWith("goal_")) return "goal";
  if (code === "contact") return "contact";
  return code === "log" || code === "overrun" ? null : "event";
}

/** Return marks that can be told apart on a line from `start` to `end`. */
export function merged(
  markers: readonly Marker[],
  start: number,
  end: number,
): readonly Marker[] {
  const width = MERGED * (end - start);
  const groups: Marker[][] = [];
  for (const marker of markers) {
    if (marker.at < start || marker.at > end) continue;
    const group = groups.at(-1);
    const first = group?.[0];
    if (group && first && marker.at - first.at <= width) group.push(marker);
    else groups.push([marker]);
  }
  return groups.map(joined);
}

function joined(group: readonly Marker[]): Marker {
  const [first] = group;
  const kind = group
    .map((one) => one.kind)
    .reduce((one, other) => (ORDER.indexOf(other) > ORDER.indexOf(one) ? other : one));
  const texts = [...new Set(group.map(({ text }) => text))];
  const shown = texts.slice(0, MOST_TEXTS);
  if (texts.length > shown.length) shown.push("…");
  return { at: first?.at ?? 0, kind, text: shown.join("\n") };
}

/** Return the nearest mark after (+1) or before (−1) a place, or undefined. */
export function neighbour(
  markers: readonly Marker[],
  at: number,
  direction: 1 | -1,
): Marker | undefined {
  return direction > 0
    ? markers.find((marker) => marker.at > at + REACHED)
    : markers.filter((marker) => marker.at < at - REACHED).at(-1);
}
