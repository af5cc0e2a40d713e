/** Units, ranges and colours of the plots. */
import { type AngleUnit, DEGREES, MILLIMETRES, RADIANS, type Unit } from "../units";
import type { Kind } from "./signals";

/** `shown = factor * value`. */
export type Scale = Pick<Unit, "symbol" | "factor" | "digits">;

/** Return how values of a kind are shown. */
export function scaleOf(kind: Kind, angle: AngleUnit): Scale {
  const turning = angle === "deg" ? DEGREES : RADIANS;
  const per = ({ symbol, factor, digits }: Unit) => ({
    ...{ symbol: `${symbol}/s`, factor, digits },
  });
  switch (kind) {
    case "angle":
      return turning;
    case "length":
      return MILLIMETRES;
    case "angular-velocity":
      return per(turning);
    case "velocity":
      return per(MILLIMETRES);
    case "torque":
      return { symbol: "N·m", factor: 1, digits: 2 };
    case "force":
      return { symbol: "N", factor: 1, digits: 2 };
    case "ratio":
      return { symbol: "×", factor: 1, digits: 2 };
    case "count":
      return { symbol: "", factor: 1, digits: 0 };
  }
}

const SI: Record<Kind, string> = {
  angle: "rad",
  length: "m",
  "angular-velocity": "rad/s",
  velocity: "m/s",
  torque: "N*m",
  force: "N",
  ratio: "1",
  count: "1",
};

/** Return the unit of a kind in SI, as files have it. */
export function siUnit(kind: Kind): string {
  return SI[kind];
}

/**
 * Return the range of an axis: the values and `also`, with a margin.  Differences below
 * what the last of `digits` shows are not enlarged.
 */
export function rangeOf(
  least: number | null,
  most: number | null,
  digits: number,
  also: readonly number[] = [],
): [number, number] {
  const low = Math.min(least ?? 0, ...also);
  const high = Math.max(most ?? 0, ...also);
  const finest = 10 ** -digits;
  if (high - low > finest) {
    const air = 0.06 * (high - low);
    return [low - air, high + air];
  }
  const around = Math.max(5 * finest, 0.05 * Math.abs(high));
  return [low - around, high + around];
}

/** Return the text of a tick, with the digits that ticks `apart` from each other need. */
export function tickText(tick: number, apart: number): string {
  const digits = 1 - Math.floor(Math.log10(apart));
  return String(Number(tick.toFixed(Math.max(0, digits))));
}

/**
 * Return the limits, of `limit` and its negative, of which the values use more than half:
 * below that the distance to the limit does not matter.
 */
export function limitsNear(
  limit: number | undefined,
  values: readonly (number | null)[],
): number[] {
  if (limit === undefined) return [];
  const isNear = (bound: number) =>
    values.some((value) => value !== null && value / bound > 0.5);
  return [limit, -limit].filter(isNear);
}

export const COLOURS = 6;

/** Return the colour that the fewest of the chosen signals have. */
export function freeColour(used: Iterable<number>): number {
  const counts = new Array<number>(COLOURS).fill(0);
  for (const colour of used) counts[colour] = (counts[colour] ?? 0) + 1;
  return counts.indexOf(Math.min(...counts));
}
