/** The frame in which the page shows positions and orientations: one for all of them. */
import { t } from "./i18n";
import { compose, fromRpy, toRpy } from "./kinematics";
import type { Pose } from "./kinematics";
import type { Target } from "./moving";
import { robots } from "./robots";
import { arm, framePose, inFrame, numberFrame } from "./tool";
import type { Vector } from "./urdf";

/** Return the name of the frame, for people. */
export function frameName(): string {
  const name = t(`tool.frame.${numberFrame.value}`);
  const isOneOfSeveral = numberFrame.value === "base" && robots.value.length > 0;
  return isOneOfSeveral ? `${name} (${arm.value?.name ?? ""})` : name;
}

/** Return a pose of the root in the frame. */
export function inNumberFrame(pose: Pose): Pose {
  return inFrame(pose, numberFrame.value);
}

/** Return a pose of the frame in the root. */
export function fromNumberFrame(pose: Pose): Pose {
  return compose(framePose(numberFrame.value), pose);
}

function convert({ position, rpy }: Target, by: (pose: Pose) => Pose): Target {
  const { p, R } = by({ p: position, R: fromRpy(rpy) });
  return { position: tidied(p), rpy: tidied(toRpy(R)) };
}

/** Return numbers without what the conversion added to them: programs are read by people. */
function tidied([x, y, z]: Vector): Vector {
  const tidy = (value: number) => Math.round(value * 1e9) / 1e9 + 0;
  return [tidy(x), tidy(y), tidy(z)];
}

/** Return the numbers that are shown for a target in the root. */
export function shownTarget(target: Target): Target {
  return numberFrame.value === "world" ? target : convert(target, inNumberFrame);
}

/** Return the target in the root that shown numbers mean. */
export function meantTarget(shown: Target): Target {
  return numberFrame.value === "world" ? shown : convert(shown, fromNumberFrame);
}
