/** SI everywhere, but degrees and millimetres on the screen, if a person likes. */
import { effect, signal } from "@preact/signals";
import type { JointInfo } from "./protocol";
import { recall, remember } from "./ui/memory";

export type AngleUnit = "rad" | "deg";

export const angleUnit = signal<AngleUnit>(recall("angle", ["rad", "deg"]) ?? "rad");
effect(() => {
  remember("angle", angleUnit.value);
});

/** How values of a joint are shown: `shown = factor * value`. */
export interface Unit {
  readonly symbol: string;
  readonly factor: number;
  readonly digits: number;
  /** What an arrow key adds [shown]. */
  readonly step: number;
}

export const RADIANS: Unit = { symbol: "rad", factor: 1, digits: 3, step: 0.01 };
export const DEGREES: Unit = { symbol: "°", factor: 180 / Math.PI, digits: 1, step: 1 };
export const MILLIMETRES: Unit = { symbol: "mm", factor: 1000, digits: 1, step: 1 };

export function unitOf(type: JointInfo["type"], angle: AngleUnit): Unit {
  if (type === "prismatic") return MILLIMETRES;
  return angle === "deg" ? DEGREES : RADIANS;
}

/** Return what a slider spans [rad | m]: the limits, or two turns, or a metre to each side. */
export function spanOf(joint: JointInfo): readonly [number, number] {
  const beyond = joint.type === "prismatic" ? 1 : 2 * Math.PI;
  return [joint.lower ?? -beyond, joint.upper ?? beyond];
}
