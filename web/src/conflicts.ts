/** Running controllers that conflict with one to be started. */
import type { ControllerInfo } from "./protocol";

/** Return the names of running controllers that claim a joint which `wanted` claims too. */
export function conflicting(
  wanted: ControllerInfo,
  all: readonly ControllerInfo[],
): readonly string[] {
  if (wanted.interface === null) return [];
  const claimed = new Set(wanted.joints);
  return all
    .filter(
      (other) =>
        other.name !== wanted.name &&
        other.is_running &&
        other.interface !== null &&
        other.joints.some((joint) => claimed.has(joint)),
    )
    .map((other) => other.name);
}
