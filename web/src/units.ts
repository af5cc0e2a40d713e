/** SI everywhere; on the screen degrees and millimetres are an option. */
import type { JointInfo } from "./protocol";
import { remembered } from "./ui/memory";

const ANGLE_UNITS = ["rad", "deg"] as const;
export type AngleUnit = (typeof ANGLE_UNITS)[number];

export const angleUnit = remembered<AngleUnit>("angle", ANGLE_UNITS, "rad");

/** How values of a joint are shown: `shown = factor * value`. */
export interface Unit {
  readonly symbol: string;
  readonly factor: number;
  readonly digits: number;
  /** Step of an arrow key [shown]. */
  readonly step: number;
}

export const RADIANS: Unit = { symbol: "rad", factor: 1, digits: 3, step: 0.01 };
export const DEGREES: Unit = { symbol: "°", factor: 180 / Math.PI, digits: 1, step: 1 };
export const MILLIMETRES: Unit = { symbol: "mm", factor: 1000, digits: 1, step: 1 };

/** Units that a user may type after a number, in terms of the first one. */
const KINDS: readonly Readonly<Record<string, number>>[] = [
  { rad: 1, deg: Math.PI / 180, "°": Math.PI / 180 },
  { m: 1, cm: 0.01, mm: 0.001 },
  { "m/s": 1, "mm/s": 0.001 },
  { kg: 1, g: 0.001 },
  { N: 1 },
];

/** Return the units that a user may type for a value in `unit`. */
function unitsLike(unit: string): Readonly<Record<string, number>> {
  return KINDS.find((kind) => unit in kind) ?? {};
}

/**
 * Return the user's input as a number of `unit`s: `1.5`, `90deg`, `40 mm`.  Without a
 * unit it is in `unit`; a comma is accepted as a decimal point.
 */
export function parseQuantity(text: string, unit: string): number | undefined {
  const cleaned = text.trim().replace("−", "-").replace(",", ".");
  const match = /^([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*(\D*)$/i.exec(cleaned);
  if (match === null) return undefined;
  const [, number, typed] = match;
  if (typed === "" || typed === unit) return Number(number);
  const units = unitsLike(unit);
  const [from, to] = [units[typed ?? ""], units[unit]];
  if (from === undefined || to === undefined) return undefined;
  return (Number(number) * from) / to;
}

export function unitOf(type: JointInfo["type"], angle: AngleUnit): Unit {
  if (type === "prismatic") return MILLIMETRES;
  return angle === "deg" ? DEGREES : RADIANS;
}

/** Return a joint's limits [rad | m]; infinite where there are none. */
export function limitsOf(joint: JointInfo): readonly [number, number] {
  return [joint.lower ?? -Infinity, joint.upper ?? Infinity];
}

/** Return the range of a slider [rad | m]: the limits, or two turns, or a metre to each side. */
export function spanOf(joint: JointInfo): readonly [number, number] {
  const beyond = joint.type === "prismatic" ? 1 : 2 * Math.PI;
  return [joint.lower ?? -beyond, joint.upper ?? beyond];
}
