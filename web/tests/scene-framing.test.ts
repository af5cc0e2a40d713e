import { Box3, PerspectiveCamera, Vector3 } from "three";
import { describe, expect, test } from "vitest";
import {
  directionOf,
  distanceFor,
  toolDirection,
  VIEWS,
  type View,
} from "../src/scene/framing";

const BOXES = {
  "an arm": new Box3(new Vector3(-0.2, -0.3, 0), new Vector3(0.7, 0.3, 1.1)),
  "a table": new Box3(new Vector3(-1, -1, 0), new Vector3(1, 1, 0.02)),
  "a pole": new Box3(new Vector3(0.4, 0.4, 0), new Vector3(0.41, 0.41, 2)),
};
const FIXED = VIEWS.filter((view): view is Exclude<View, "tool"> => view !== "tool");

/** Where the corners are in the picture: its edges are at ±1. */
function corners(box: Box3, direction: Vector3, distance: number, aspect: number) {
  const camera = new PerspectiveCamera(32, aspect, 0.01, 100);
  camera.up.set(0, 0, 1);
  const centre = box.getCenter(new Vector3());
  camera.position.copy(centre).addScaledVector(direction, distance);
  camera.lookAt(centre);
  camera.updateMatrixWorld();
  const seen: Vector3[] = [];
  for (const x of [box.min.x, box.max.x]) {
    for (const y of [box.min.y, box.max.y]) {
      for (const z of [box.min.z, box.max.z]) {
        seen.push(new Vector3(x, y, z).project(camera));
      }
    }
  }
  return seen;
}

describe.each(Object.entries(BOXES))("%s is framed", (_name, box) => {
  test.each(FIXED)("from the view %s, whole and as large as it fits", (view) => {
    for (const aspect of [0.6, 1, 1.8]) {
      const direction = directionOf(view);
      const distance = distanceFor(box, direction, { fov: 32, aspect });
      const seen = corners(box, direction, distance, aspect);
      const furthest = Math.max(
        ...seen.flatMap(({ x, y }) => [Math.abs(x), Math.abs(y)]),
      );
      expect(furthest).toBeLessThanOrEqual(1 + 1e-6);
      expect(furthest).toBeGreaterThan(0.98);
    }
  });
});

test("views are named as REP-103 has it: x forward, y left, z up", () => {
  expect(directionOf("front").x).toBeGreaterThan(0.99);
  expect(directionOf("left").y).toBeGreaterThan(0.99);
  expect(directionOf("right").y).toBeLessThan(-0.99);
  expect(directionOf("top").z).toBeGreaterThan(0.99);
});

describe("the close-up of a gripper", () => {
  test("looks along the axis of its fingers, so that they are seen to open", () => {
    const direction = toolDirection(new Vector3(0, 1, 0), new Vector3(1, -1, 0.5));
    expect(Math.abs(direction.y)).toBeGreaterThan(0.7);
  });

  test("stays on the side where the camera is, and above", () => {
    const axis = new Vector3(0, 1, 0);
    const camera = new Vector3(1, -1, 0.5).normalize();
    expect(toolDirection(axis, camera).dot(camera)).toBeGreaterThan(0.7);
    expect(toolDirection(axis, camera).z).toBeGreaterThan(0.1);
    expect(toolDirection(axis, camera.clone().negate()).y).toBeGreaterThan(0.7);
  });

  test("works for an upright axis too", () => {
    const direction = toolDirection(new Vector3(0, 0, 1), new Vector3(1, 0, 0.2));
    expect(direction.length()).toBeCloseTo(1);
    expect(direction.z).toBeGreaterThan(0.8);
  });
});
