/** Steps from how robot and scene are now. */
import { frames } from "../frames";
import { fromQuaternion, linkPose, toRpy } from "../kinematics";
import { model } from "../model";
import type { RobotPartsInfo, ToolPose } from "../protocol";
import { selected } from "../robots";
import { jointIndex, scene, view } from "../store";
import type { UrdfModel } from "../urdf";
import type { Kind, MoveStep, Step } from "./steps";

/** The robot whose arm a program moves. */
export function programRobot(): RobotPartsInfo | undefined {
  return selected.peek() ?? view.peek()?.robot.robots[0];
}

/** Return the movable joints from the base of an arm to its flange. */
export function armJoints(tree: UrdfModel, robot: RobotPartsInfo): string[] {
  const found: string[] = [];
  for (let link = robot.tip; link !== robot.base;) {
    const joint = tree.parentJoint.get(link);
    if (joint === undefined) break;
    if (joint.type !== "fixed") found.unshift(joint.name);
    link = joint.parent;
  }
  return found;
}

function positionOf(joint: string): number | undefined {
  return frames.latest?.position[jointIndex.peek().get(joint) ?? -1];
}

/** Return where the joints of the arm are now [rad]; undefined before that is known. */
export function presentJoints(): Record<string, number> | undefined {
  const [robot, tree] = [programRobot(), model.peek()];
  if (robot === undefined || tree === null || frames.latest === undefined) {
    return undefined;
  }
  return Object.fromEntries(
    armJoints(tree, robot).map((name) => [name, rounded(positionOf(name) ?? 0)]),
  );
}

/** Return where the flange is now, in the robot's root; undefined before that is known. */
export function presentPose(): ToolPose | undefined {
  const [robot, tree] = [programRobot(), model.peek()];
  if (robot === undefined || tree === null || frames.latest === undefined) {
    return undefined;
  }
  const { p, R } = linkPose(tree, robot.tip, positionOf);
  const [x, y, z] = p.map(rounded);
  const [roll, pitch, yaw] = toRpy(R).map(rounded);
  return { xyz: [x ?? 0, y ?? 0, z ?? 0], rpy: [roll ?? 0, pitch ?? 0, yaw ?? 0] };
}

/** Files shall be readable: a micrometre, a microradian. */
function rounded(value: number): number {
  return Math.round(value * 1e6) / 1e6 + 0;
}

/** Return a move with the present posture as its target. */
export function taught<S extends MoveStep>(step: S): S {
  const joints = presentJoints();
  return joints ? { ...step, joints, pose: null, named_pose: null } : step;
}

/** Return where an object is now, for a step. */
export function placeOfObject(name: string): Extract<Step, { kind: "place_object" }> {
  const at = scene.peek()?.objects.findIndex((one) => one.name === name) ?? -1;
  const [xyz, quaternion] = frames.latest?.objects[at] ?? [];
  const rpy = quaternion ? toRpy(fromQuaternion(quaternion)).map(rounded) : [];
  const [x = 0, y = 0, z = 0] = (xyz ?? []).map(rounded);
  const [roll = 0, pitch = 0, yaw = 0] = rpy;
  return { kind: "place_object", name, xyz: [x, y, z], rpy: [roll, pitch, yaw] };
}

/** Return a new step of a kind, as the robot and the scene are now. */
export function newStep(kind: Kind): Step {
  switch (kind) {
    case "move_joint":
    case "move_linear":
      return taught({ kind });
    case "gripper":
      return { kind, opening: "closed" };
    case "wait":
      return { kind, duration: 1 };
    case "until":
      return { kind, direction: [0, 0, -1], distance: 0.1 };
    case "place_object":
      return placeOfObject(
        scene.peek()?.objects.find(({ mass }) => mass !== null)?.name ??
          scene.peek()?.objects[0]?.name ??
          "object",
      );
    case "set_output":
      return { kind, output: 0, level: true };
    case "comment":
      return { kind, text: "" };
    case "loop":
      return { kind, times: 2, steps: [] };
  }
}
