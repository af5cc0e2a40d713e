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

/** A row of a homogeneous transform. */
export type Row = [number, number, number, number];

export const IDENTITY: Pose = {
  p: [0, 0, 0],
  R: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
};

/** Return a pose as requests have it: a homogeneous transform, row by row. */
export function matrixOf({ p, R }: Pose): [Row, Row, Row, Row] {
  const row = (i: 0 | 1 | 2): Row => [R[i][0], R[i][1], R[i][2], p[i]];
  return [row(0), row(1), row(2), [0, 0, 0, 1]];
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** Return `v` in the axes that `R` turns it to. */
export function apply(R: Rotation, v: Vector): Vector {
  return [dot(R[0], v), dot(R[1], v), dot(R[2], v)];
}

export function product(A: Rotation, B: Rotation): Rotation {
  const column = (j: 0 | 1 | 2): Vector => [B[0][j], B[1][j], B[2][j]];
  const row = (a: Vector): Vector => [
    dot(a, column(0)),
    dot(a, column(1)),
    dot(a, column(2)),
  ];
  return [row(A[0]), row(A[1]), row(A[2])];
}

/** Return T_a_c. */
export function compose(T_a_b: Pose, T_b_c: Pose): Pose {
  const [x, y, z] = apply(T_a_b.R, T_b_c.p);
  const p: Vector = [T_a_b.p[0] + x, T_a_b.p[1] + y, T_a_b.p[2] + z];
  return { p, R: product(T_a_b.R, T_b_c.R) };
}

/** Return where a point of a frame is, whose pose is given [m]. */
export function pointAt(T_root_frame: Pose, point: Vector): Vector {
  return compose(T_root_frame, { p: point, R: IDENTITY.R }).p;
}

export function transposed(R: Rotation): Rotation {
  return [
    [R[0][0], R[1][0], R[2][0]],
    [R[0][1], R[1][1], R[2][1]],
    [R[0][2], R[1][2], R[2][2]],
  ];
}

/** Return T_b_a. */
export function inverse({ p, R }: Pose): Pose {
  const back = transposed(R);
  const [x, y, z] = apply(back, p);
  return { p: [-x, -y, -z], R: back };
}

/** Return the rotation by a rotation vector [rad]. */
export function fromRotationVector(v: Vector): Rotation {
  return aboutAxis(v, Math.hypot(...v));
}

/** Return the rotation vector of a rotation [rad], at most pi long. */
export function toRotationVector(R: Rotation): Vector {
  const [w, x, y, z] = toQuaternion(R);
  const sine = Math.hypot(x, y, z);
  const k = sine < 1e-12 ? 2 : (2 * Math.atan2(sine, w)) / sine;
  return [k * x, k * y, k * z];
}

/** Return the unit quaternion of a rotation, its w not negative. */
export function toQuaternion(R: Rotation): Quaternion {
  const size = (a: number, b: number, c: number) =>
    Math.sqrt(Math.max(0, 1 + a * R[0][0] + b * R[1][1] + c * R[2][2])) / 2;
  const parts = [size(1, 1, 1), size(1, -1, -1), size(-1, 1, -1), size(-1, -1, 1)];
  const largest = parts.indexOf(Math.max(...parts));
  const k = 1 / (4 * (parts[largest] ?? 1));
  const [dx, dy, dz] = [R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1]];
  const [xy, xz, yz] = [R[0][1] + R[1][0], R[0][2] + R[2][0], R[1][2] + R[2][1]];
  const m = 1 / (4 * k);
  const found: Quaternion =
    largest === 0
      ? [m, k * dx, k * dy, k * dz]
      : largest === 1
        ? [k * dx, m, k * xy, k * xz]
        : largest === 2
          ? [k * dy, k * xy, m, k * yz]
          : [k * dz, k * xz, k * yz, m];
  const sign = found[0] < 0 ? -1 : 1;
  return [sign * found[0], sign * found[1], sign * found[2], sign * found[3]];
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

/** Return the rotation by `angle` [rad] about `axis`. */
export function aboutAxis(axis: Vector, angle: number): Rotation {
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
