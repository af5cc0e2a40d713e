/** The names of signals for the user. */
import { type Key, t } from "../i18n";
import { withoutPrefix } from "../robots";
import type { Group, SignalInfo } from "./signals";

export const GROUPS: readonly Group[] = [
  "joint-position",
  "joint-desired",
  "joint-error",
  "joint-velocity",
  "joint-effort",
  "tool",
  "wrench",
  "gripper",
  "object",
  "simulation",
];

const QUANTITIES: Readonly<Record<string, Key>> = {
  position: "plots.quantity.position",
  desired: "plots.quantity.desired",
  error: "plots.quantity.error",
  velocity: "plots.quantity.velocity",
  effort: "plots.quantity.effort",
  simulated: "plots.quantity.simulated",
  simulated_effort: "plots.quantity.simulatedEffort",
  opening: "plots.quantity.opening",
  force: "plots.quantity.force",
  width: "plots.quantity.width",
  real_time_factor: "plots.quantity.realTimeFactor",
  late_ticks: "plots.quantity.lateTicks",
};

export function groupName(group: Group): string {
  return t(`plots.group.${group}`);
}

/** Return what a signal measures, such as `velocity` or `x`. */
export function quantityName({ quantity }: SignalInfo): string {
  const key = QUANTITIES[quantity];
  return key === undefined ? quantity : t(key);
}

/** Return what a signal is of, and which value of it. */
export function signalName(info: SignalInfo): string {
  return `${withoutPrefix(info.of)} ${quantityName(info)}`.trim();
}
