/** The quantities that can be plotted, and their units. */
import type { JointInfo } from "../protocol";
import { type AngleUnit, unitOf } from "../units";
import type { Quantity } from "./recording";

/** One choice of the panel; `position` shows desired and actual. */
export type Plotted = "position" | "error" | "velocity" | "effort";
export const PLOTTED: readonly Plotted[] = ["position", "error", "velocity", "effort"];

export interface Scale {
  readonly symbol: string;
  /** Shown value by SI value. */
  readonly factor: number;
  readonly digits: number;
}

export function scaleOf(
  plotted: Plotted,
  type: JointInfo["type"],
  angle: AngleUnit,
): Scale {
  const slides = type === "prismatic";
  if (plotted === "effort")
    return { symbol: slides ? "N" : "N·m", factor: 1, digits: 2 };
  const { symbol, factor, digits } = unitOf(type, angle);
  if (plotted === "velocity") return { symbol: `${symbol}/s`, factor, digits };
  return { symbol, factor, digits: plotted === "error" ? digits + 2 : digits };
}

/** Return the unit of a quantity in SI, as files have it. */
export function siUnit(quantity: Quantity, type: JointInfo["type"]): string {
  const slides = type === "prismatic";
  if (quantity === "effort") return slides ? "N" : "N*m";
  const unit = slides ? "m" : "rad";
  return quantity === "velocity" ? `${unit}/s` : unit;
}

/** Return the range of an axis: the values and `also`, with a margin. */
export function rangeOf(
  least: number | null,
  most: number | null,
  also: readonly number[] = [],
): [number, number] {
  const low = Math.min(least ?? 0, ...also);
  const high = Math.max(most ?? 0, ...also);
  const air = 0.06 * (high - low);
  if (air > 1e-9) return [low - air, high + air];
  const around = Math.max(0.01, 0.05 * Math.abs(high));
  return [low - around, high + around];
}

/**
 * Return the limits, of `limit` and its negative, of which a joint uses more than half:
 * below that the distance to the limit does not matter.
 */
export function limitsNear(
  limit: number | null,
  values: readonly (number | null)[],
): number[] {
  if (limit === null) return [];
  const isNear = (bound: number) =>
    values.some((value) => value !== null && value / bound > 0.5);
  return [limit, -limit].filter(isNear);
}

export const COLOURS = 6;

/** Return the colour that the fewest of the chosen joints have. */
export function freeColour(used: Iterable<number>): number {
  const counts = new Array<number>(COLOURS).fill(0);
  for (const colour of used) counts[colour] = (counts[colour] ?? 0) + 1;
  return counts.indexOf(Math.min(...counts));
}
