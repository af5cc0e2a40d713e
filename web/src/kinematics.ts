/** Forward kinematics: poses of the links in the root from the joint positions. */
import type { UrdfJoint, UrdfModel, Vector } from "./urdf";

/** Rotation, row by row. */
export type Rotation = readonly [Vector, Vector, Vector];

/** w, x, y, z. */
export type Quaternion = readonly [number, number, number, number];

export interface Pose {
  /** [m] */
  readonly p: Vector;
  readonly R: Rotation;
}

const IDENTITY: Pose = {
  p: [0, 0, 0],
  R: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
};

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function apply(R: Rotation, v: Vector): Vector {
  return [dot(R[0], v), dot(R[1], v), dot(R[2], v)];
}

function product(A: Rotation, B: Rotation): Rotation {
  const column = (j: 0 | 1 | 2): Vector => [B[0][j], B[1][j], B[2][j]];
  const row = (a: Vector): Vector => [
    dot(a, column(0)),
    dot(a, column(1)),
    dot(a, column(2)),
  ];
  return [row(A[0]), row(A[1]), row(A[2])];
}

function compose(T_a_b: Pose, T_b_c: Pose): Pose {
  const [x, y, z] = apply(T_a_b.R, T_b_c.p);
  const p: Vector = [T_a_b.p[0] + x, T_a_b.p[1] + y, T_a_b.p[2] + z];
  return { p, R: product(T_a_b.R, T_b_c.R) };
}

/** Return the rotation by `rpy` about fixed axes, as URDF means it: Rz · Ry · Rx. */
export function fromRpy([roll, pitch, yaw]: Vector): Rotation {
  const [sr, cr] = [Math.sin(roll), Math.cos(roll)];
  const [sp, cp] = [Math.sin(pitch), Math.cos(pitch)];
  const [sy, cy] = [Math.sin(yaw), Math.cos(yaw)];
  return [
    [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
    [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
    [-sp, cp * sr, cp * cr],
  ];
}

/** Return the rotation of a unit quaternion w, x, y, z. */
export function fromQuaternion([w, x, y, z]: Quaternion): Rotation {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ];
}

/** Return roll, pitch and yaw of a rotation [rad]; the inverse of `fromRpy`. */
export function toRpy(R: Rotation): Vector {
  const cosine = Math.hypot(R[0][0], R[1][0]);
  const pitch = Math.atan2(-R[2][0], cosine);
  if (cosine < 1e-9) return [0, pitch, Math.atan2(-R[0][1], R[1][1])];
  return [Math.atan2(R[2][1], R[2][2]), pitch, Math.atan2(R[1][0], R[0][0])];
}

function aboutAxis(axis: Vector, angle: number): Rotation {
  const length = Math.hypot(...axis) || 1;
  const [x, y, z] = [axis[0] / length, axis[1] / length, axis[2] / length];
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  const k = 1 - c;
  return [
    [c + x * x * k, x * y * k - z * s, x * z * k + y * s],
    [y * x * k + z * s, c + y * y * k, y * z * k - x * s],
    [z * x * k - y * s, z * y * k + x * s, c + z * z * k],
  ];
}

function motion(joint: UrdfJoint, position: number): Pose {
  if (joint.type === "revolute" || joint.type === "continuous") {
    return { p: [0, 0, 0], R: aboutAxis(joint.axis, position) };
  }
  if (joint.type !== "prismatic") return IDENTITY;
  const length = Math.hypot(...joint.axis) || 1;
  const scale = position / length;
  const [x, y, z] = joint.axis;
  return { p: [x * scale, y * scale, z * scale], R: IDENTITY.R };
}

/** Return the pose of `link` in the root, for joints at `positionOf` [rad | m]. */
export function linkPose(
  model: UrdfModel,
  link: string,
  positionOf: (joint: string) => number | undefined,
): Pose {
  const joint = model.parentJoint.get(link);
  if (joint === undefined) return IDENTITY;
  const followed = joint.mimic && positionOf(joint.mimic.joint);
  const mimicked =
    joint.mimic && (followed ?? 0) * joint.mimic.multiplier + joint.mimic.offset;
  const position = positionOf(joint.name) ?? mimicked ?? 0;
  const origin: Pose = { p: joint.origin.xyz, R: fromRpy(joint.origin.rpy) };
  const T_root_parent = linkPose(model, joint.parent, positionOf);
  return compose(compose(T_root_parent, origin), motion(joint, position));
}
