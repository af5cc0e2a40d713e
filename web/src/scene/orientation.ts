/** Rotations of `kinematics` for three. */
import { Quaternion } from "three";
import { fromQuaternion, type Rotation, toQuaternion } from "../kinematics";

/** Return a rotation as a quaternion of three. */
export function quaternionOf(R: Rotation): Quaternion {
  const [w, x, y, z] = toQuaternion(R);
  return new Quaternion(x, y, z, w);
}

/** Return the rotation of a unit quaternion of three. */
export function rotationOf({ w, x, y, z }: Quaternion): Rotation {
  return fromQuaternion([w, x, y, z]);
}
