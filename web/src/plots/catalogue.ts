/** The signals of a robot and its surroundings, and how they follow from what the server sends. */
import { openingAt } from "../gripper-opening";
import { fromQuaternion, linkPose, type Pose, toRpy } from "../kinematics";
import type { Frame } from "../messages";
import type {
  GripperInfo,
  JointInfo,
  RobotPartsInfo,
  ViewInfo,
  ViewScene,
} from "../protocol";
import type { UrdfModel, Vector } from "../urdf";
import type { Moment } from "./history";
import type { Kind, SignalInfo } from "./signals";

/** A signal of a running robot. */
export interface LiveSignal extends SignalInfo {
  /** Return its value [SI], or undefined where nothing is known. */
  readonly value: (moment: Moment) => number | null | undefined;
}

const PLACES = ["x", "y", "z"] as const;
const ANGLES = ["roll", "pitch", "yaw"] as const;
const FORCES = ["fx", "fy", "fz"] as const;
const TORQUES = ["tx", "ty", "tz"] as const;

type Indexed = readonly [JointInfo, number];

/** Return the signals of a joint; those of a simulated run beside it, if there is one. */
function jointSignals([joint, i]: Indexed, isCompared: boolean): LiveSignal[] {
  const slides = joint.type === "prismatic";
  const of = joint.name;
  const id = (quantity: string) => `joint/${of}/${quantity}`;
  const position = slides ? "length" : "angle";
  return [
    {
      ...{ id: id("position"), group: "joint-position", of, quantity: "position" },
      ...{ kind: position, desired: id(isCompared ? "simulated" : "desired") },
      value: ({ frame }) => frame.position[i],
    },
    {
      ...{ id: id("desired"), group: "joint-desired", of, quantity: "desired" },
      kind: position,
      value: ({ frame }) => frame.desired[i],
    },
    {
      ...{ id: id("error"), group: "joint-error", of, quantity: "error" },
      kind: position,
      value: ({ frame }) => {
        const [desired, actual] = [frame.desired[i] ?? null, frame.position[i]];
        return desired === null || actual === undefined ? null : desired - actual;
      },
    },
    {
      ...{ id: id("velocity"), group: "joint-velocity", of, quantity: "velocity" },
      kind: slides ? "velocity" : "angular-velocity",
      value: ({ frame }) => frame.velocity[i],
    },
    {
      ...{ id: id("effort"), group: "joint-effort", of, quantity: "effort" },
      kind: slides ? "force" : "torque",
      ...(joint.effort !== null && { limit: joint.effort }),
      ...(isCompared && { desired: id("simulated_effort") }),
      value: ({ frame }) => frame.effort[i],
    },
    ...(isCompared ? simulatedSignals(of, position, slides ? "force" : "torque") : []),
  ];
}

/** Return the signals of a joint of a simulated run, which only its server knows. */
function simulatedSignals(of: string, position: Kind, effort: Kind): LiveSignal[] {
  const value = () => undefined;
  const id = `joint/${of}/simulated`;
  return [
    {
      ...{ id, group: "joint-position", of, quantity: "simulated" },
      ...{ kind: position, value },
    },
    {
      ...{ id: `${id}_effort`, group: "joint-effort", of },
      ...{ quantity: "simulated_effort", kind: effort, value },
    },
  ];
}

/** Return the signals of a pose; `poseOf` is called once for each moment. */
function poseSignals(
  group: "tool" | "object",
  of: string,
  poseOf: (moment: Moment) => Pose | undefined,
): LiveSignal[] {
  const known = new WeakMap<Moment, { p: Vector; rpy: Vector } | undefined>();
  const at = (moment: Moment) => {
    if (!known.has(moment)) {
      const pose = poseOf(moment);
      known.set(moment, pose && { p: pose.p, rpy: toRpy(pose.R) });
    }
    return known.get(moment);
  };
  return [
    ...PLACES.map((quantity, axis): LiveSignal => ({
      ...{ id: `${group}/${of}/${quantity}`, group, of, quantity, kind: "length" },
      value: (moment) => at(moment)?.p[axis],
    })),
    ...ANGLES.map((quantity, axis): LiveSignal => ({
      ...{ id: `${group}/${of}/${quantity}`, group, of, quantity, kind: "angle" },
      value: (moment) => at(moment)?.rpy[axis],
    })),
  ];
}

function toolSignals(
  model: UrdfModel,
  { name, tip }: RobotPartsInfo,
  indexOf: ReadonlyMap<string, number>,
): LiveSignal[] {
  const positionOf =
    ({ position }: Frame) =>
    (joint: string) => {
      const index = indexOf.get(joint);
      return index === undefined ? undefined : position[index];
    };
  return poseSignals("tool", name, ({ frame }) =>
    linkPose(model, tip, positionOf(frame)),
  );
}

function wrenchSignals({ name }: RobotPartsInfo): LiveSignal[] {
  const group = "wrench";
  const value =
    (axis: number) =>
    ({ frame }: Moment) =>
      frame.wrenches?.[name]?.[axis];
  return [
    ...FORCES.map((quantity, axis): LiveSignal => ({
      ...{ id: `wrench/${name}/${quantity}`, group, of: name, quantity, kind: "force" },
      value: value(axis),
    })),
    ...TORQUES.map((quantity, axis): LiveSignal => ({
      ...{ id: `wrench/${name}/${quantity}`, group, of: name, quantity },
      kind: "torque",
      value: value(3 + axis),
    })),
  ];
}

function gripperSignals(info: GripperInfo, joint: number): LiveSignal[] {
  const of = info.name;
  const { pad_cos, pad_sin, pad_slope } = info;
  const id = (quantity: string) => `gripper/${of}/${quantity}`;
  return [
    {
      ...{ id: id("opening"), group: "gripper", of, quantity: "opening" },
      kind: "length",
      value: ({ frame }) => openingAt(info, frame.position[joint] ?? NaN),
    },
    {
      ...{ id: id("force"), group: "gripper", of, quantity: "force", kind: "force" },
      value: ({ frame }) => {
        const q = frame.position[joint] ?? NaN;
        const turning = pad_sin * Math.cos(q) - pad_cos * Math.sin(q);
        return (frame.effort[joint] ?? NaN) / (2 * Math.abs(turning + pad_slope));
      },
    },
    {
      ...{ id: id("width"), group: "gripper", of, quantity: "width", kind: "length" },
      value: ({ status }) => status?.grippers.find(({ name }) => name === of)?.width,
    },
  ];
}

const indices = new WeakMap<ViewScene, ReadonlyMap<string, number>>();

function indexIn(scene: ViewScene, name: string): number | undefined {
  let found = indices.get(scene);
  if (found === undefined) {
    found = new Map(scene.objects.map((object, index) => [object.name, index]));
    indices.set(scene, found);
  }
  return found.get(name);
}

function objectSignals(name: string): LiveSignal[] {
  return poseSignals("object", name, ({ frame, scene }) => {
    if (scene?.number !== frame.scene_number) return undefined;
    const index = indexIn(scene, name);
    const pose = index === undefined ? undefined : frame.objects[index];
    return pose && { p: pose[0], R: fromQuaternion(pose[1]) };
  });
}

function simulationSignals(): LiveSignal[] {
  const [group, of] = ["simulation", ""] as const;
  return [
    {
      ...{ id: "simulation/real_time_factor", group, of, kind: "ratio" },
      quantity: "real_time_factor",
      value: ({ status }) => status?.real_time_factor,
    },
    {
      ...{ id: "simulation/late_ticks", group, of, kind: "count" },
      quantity: "late_ticks",
      value: ({ status }) => status?.late_ticks,
    },
  ];
}

/** Return every signal by id, in the order in which they are shown. */
export function signalsOf(
  { robot, mode, replay }: ViewInfo,
  model: UrdfModel | null,
  objects: readonly string[],
): ReadonlyMap<string, LiveSignal> {
  const indexed = robot.joints.map((joint, i): Indexed => [joint, i]);
  const indexOf = new Map(robot.joints.map(({ name }, i) => [name, i]));
  const isCompared = replay?.signals.some((id) => id.endsWith("/simulated")) ?? false;
  const all = [
    ...indexed.flatMap((one) => jointSignals(one, isCompared)),
    ...(model ? robot.robots.flatMap((one) => toolSignals(model, one, indexOf)) : []),
    ...(mode === "view" ? [] : robot.robots.flatMap(wrenchSignals)),
    ...robot.grippers.flatMap((info) =>
      gripperSignals(info, indexOf.get(info.joint) ?? -1),
    ),
    ...objects.flatMap(objectSignals),
    ...simulationSignals(),
  ];
  return new Map(all.map((one) => [one.id, one]));
}
