/** The arm that the controls move, and where its tool is. */
import { computed } from "@preact/signals";
import { frames } from "./frames";
import { IDENTITY, inverse, compose, linkPose } from "./kinematics";
import type { Pose } from "./kinematics";
import { model } from "./model";
import type { Frame } from "./messages";
import type { RobotPartsInfo } from "./protocol";
import { selected } from "./robots";
import { jointIndex, view } from "./store";
import type { UrdfModel } from "./urdf";
import { remembered, rememberedFlag } from "./ui/memory";

/** `world` is the robot's root, `base` the frame of UR's controller. */
export const FRAMES = ["world", "base"] as const;
export type NumberFrame = (typeof FRAMES)[number];
export type ToolFrame = NumberFrame | "tool";

/** In which the page shows all positions and orientations, if there is an arm. */
export const chosenFrame = remembered<NumberFrame>("frame", FRAMES, "world");
/** Whether the tool is jogged along its own axes, and not along those of the numbers. */
export const jogsInTool = rememberedFlag("jog-axes", ["frame", "tool"]);

/** The selected arm, or the only one; null without any. */
export const arm = computed<RobotPartsInfo | null>(
  () => selected.value ?? view.value?.robot.robots[0] ?? null,
);

export const numberFrame = computed<NumberFrame>(() =>
  arm.value === null ? "world" : chosenFrame.value,
);

/** The axes along which the tool is jogged and dragged. */
export const toolFrame = computed<ToolFrame>(() =>
  jogsInTool.value ? "tool" : numberFrame.value,
);

/** Return the link in whose axes the arm takes velocities: UR's `base`, or what carries the arm. */
export function baseLink(urdf: UrdfModel, { prefix, tip }: RobotPartsInfo): string {
  if (urdf.links.has(`${prefix}base`)) return `${prefix}base`;
  let link = tip;
  for (let turning = 0; turning < 6;) {
    const joint = urdf.parentJoint.get(link);
    if (!joint) return urdf.root;
    if (joint.type !== "fixed") turning += 1;
    link = joint.parent;
  }
  return link;
}

/** Return the pose of a link in the root: measured, or as its joints are commanded. */
export function poseOf(link: string, frame = frames.latest, commanded = false): Pose {
  const urdf = model.value;
  if (!urdf || !frame) return IDENTITY;
  return linkPose(urdf, link, (joint) => positionOf(frame, joint, commanded));
}

function positionOf(frame: Frame, joint: string, commanded: boolean) {
  const index = jointIndex.value.get(joint) ?? -1;
  const desired = commanded ? frame.desired[index] : null;
  return desired ?? frame.position[index];
}

/** Return the pose of tool0 in the root. */
export function toolPose(frame = frames.latest): Pose {
  return poseOf(arm.value?.tip ?? "", frame);
}

/** Return the pose of a frame in the root. */
export function framePose(frame: ToolFrame, now = frames.latest): Pose {
  const [urdf, robot] = [model.value, arm.value];
  if (frame === "world" || !urdf || !robot) return IDENTITY;
  return poseOf(frame === "tool" ? robot.tip : baseLink(urdf, robot), now);
}

/** Return a pose of the root in another frame. */
export function inFrame(pose: Pose, frame: ToolFrame): Pose {
  return compose(inverse(framePose(frame)), pose);
}
