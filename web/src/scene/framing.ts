/** Where a camera stands to see something whole.  Pure; z is up, x forward (REP-103). */
import { Box3, Vector3 } from "three";

export type View = "iso" | "front" | "left" | "right" | "top" | "tool";
export const VIEWS: readonly View[] = ["iso", "front", "left", "right", "top", "tool"];

/** Direction from the target to the camera; `tool` depends on how the tool is turned. */
const DIRECTIONS: Record<Exclude<View, "tool">, readonly [number, number, number]> = {
  iso: [1, -1.15, 0.62],
  front: [1, 0, 0.06],
  left: [0, 1, 0.06],
  right: [0, -1, 0.06],
  // a hair off the vertical, so that x is up in the picture
  top: [-1e-4, 0, 1],
};

const UP = new Vector3(0, 0, 1);

export function directionOf(view: Exclude<View, "tool">): Vector3 {
  return new Vector3(...DIRECTIONS[view]).normalize();
}

/**
 * Return where to look from to see a gripper move: along the axis that its fingers turn
 * about, a little from above and from the side that the camera is on.
 *
 * @param axis in the world, of a finger's joint
 * @param camera from the tool towards the camera now
 */
export function toolDirection(axis: Vector3, camera: Vector3): Vector3 {
  const direction = axis.clone().normalize();
  if (direction.dot(camera) < 0) direction.negate();
  if (Math.abs(direction.z) > 0.9)
    return direction.addScaledVector(camera, 0.3).normalize();
  const side = new Vector3().crossVectors(UP, direction).normalize();
  if (side.dot(camera) < 0) side.negate();
  return direction.addScaledVector(side, 0.45).addScaledVector(UP, 0.35).normalize();
}

export interface Lens {
  /** Vertical field of view [deg]. */
  fov: number;
  /** Width by height. */
  aspect: number;
}

/** Return how far from the middle of `box` the whole of it is seen [m]. */
export function distanceFor(box: Box3, direction: Vector3, lens: Lens): number {
  const tangent = Math.tan((lens.fov * Math.PI) / 360);
  const right = new Vector3().crossVectors(UP, direction).normalize();
  const up = new Vector3().crossVectors(direction, right);
  const centre = box.getCenter(new Vector3());
  const corner = new Vector3();
  let distance = 0;
  for (let i = 0; i < 8; i++) {
    corner
      .set(
        i & 1 ? box.max.x : box.min.x,
        i & 2 ? box.max.y : box.min.y,
        i & 4 ? box.max.z : box.min.z,
      )
      .sub(centre);
    const near = corner.dot(direction);
    const across = Math.abs(corner.dot(right)) / (tangent * lens.aspect);
    const along = Math.abs(corner.dot(up)) / tangent;
    distance = Math.max(distance, near + across, near + along);
  }
  return distance;
}
