import { type Object3D, Quaternion, Vector3 } from "three";
import { describe, expect, test } from "vitest";
import type { ViewObject, ViewScene } from "../src/protocol";
import { Materials } from "../src/scene/materials";
import { Meshes } from "../src/scene/meshes";
import { Objects } from "../src/scene/objects";

function box(name: string, size = 0.1): ViewObject {
  return {
    name,
    shape: { kind: "box", size: [size, size, size] },
    rgba: [1, 0, 0, 1],
    mass: 1,
    friction: 1,
  };
}

function scene(number: number, ...objects: ViewObject[]): ViewScene {
  return { type: "scene", number, objects };
}

/** Poses in a row along x, of a robot without joints. */
function row(number: number, count: number) {
  const values = Array.from({ length: count }, (_, i) => [i + 1, 0, 0, 1, 0, 0, 0]);
  return { time: 0, scene: number, values: new Float64Array(values.flat()) };
}

function empty(): Objects {
  const materials = new Materials("low");
  return new Objects(new Meshes(materials), materials);
}

function seen(objects: Objects): Record<string, number> {
  const visible = objects.root.children.filter((one) => one.visible);
  return Object.fromEntries(visible.map((one) => [one.name, one.position.x]));
}

function named(objects: Objects, name: string): Object3D | undefined {
  return objects.root.children.find((one) => one.name === name);
}

describe("objects of the scene", () => {
  test("come, and are seen as soon as a frame says where they are", async () => {
    const objects = empty();
    await objects.show(scene(0, box("one")));
    expect(seen(objects)).toEqual({});
    objects.pose(row(0, 1), 0);
    await objects.show(scene(1, box("one"), box("two")));
    expect(seen(objects)).toEqual({ one: 1 });
    objects.pose(row(1, 2), 0);
    expect(seen(objects)).toEqual({ one: 1, two: 2 });
  });

  test("go, while the others stay what they were", async () => {
    const objects = empty();
    await objects.show(scene(0, box("one"), box("two")));
    const two = named(objects, "two");
    await objects.show(scene(1, box("two")));
    expect(objects.root.children).toEqual([two]);
    objects.pose(row(1, 1), 0);
    expect(seen(objects)).toEqual({ two: 1 });
  });

  test("may have several shapes, each at its pose in the object", async () => {
    const objects = empty();
    const angle: ViewObject = {
      ...box("angle"),
      shape: {
        kind: "compound",
        parts: [
          { shape: { kind: "sphere", radius: 0.1 }, xyz: [0, 0, 0], rpy: [0, 0, 0] },
          {
            shape: { kind: "box", size: [1, 1, 1] },
            xyz: [1, 2, 3],
            rpy: [Math.PI / 2, 0, Math.PI / 2],
          },
        ],
      },
    };
    await objects.show(scene(0, angle));
    expect(objects.failures).toEqual([]);
    const drawn = named(objects, "angle");
    expect(drawn?.children.map((part) => part.position.toArray())).toEqual([
      [0, 0, 0],
      [1, 2, 3],
    ]);
    const second = drawn?.children[1];
    expect(second?.children[0]?.userData.object).toBe("angle");
    // about x first: the part's y goes to z and stays there
    const y = new Vector3(0, 1, 0).applyQuaternion(
      second?.quaternion ?? new Quaternion(),
    );
    expect(y.distanceTo(new Vector3(0, 0, 1))).toBeLessThan(1e-9);
  });

  test("are not put where a frame of another scene has others", async () => {
    const objects = empty();
    await objects.show(scene(3, box("one")));
    objects.pose(row(2, 1), 0);
    expect(seen(objects)).toEqual({});
  });

  test("may come again under the old name as something else", async () => {
    const objects = empty();
    await objects.show(scene(0, box("one")));
    const before = named(objects, "one");
    await objects.show(scene(1, box("one", 0.2)));
    expect(objects.root.children).toHaveLength(1);
    expect(named(objects, "one")).not.toBe(before);
  });

  test("whose mesh cannot be read are told of until they go", async () => {
    const objects = empty();
    const broken: ViewObject = {
      ...box("part"),
      shape: { kind: "mesh", size: [1, 1, 1], url: "/meshes/1.xyz" },
    };
    await objects.show(scene(0, broken, box("one")));
    expect(objects.failures.join()).toContain("/meshes/1.xyz");
    objects.pose(row(0, 2), 0);
    expect(seen(objects)).toEqual({ part: 1, one: 2 });
    await objects.show(scene(1, box("one")));
    expect(objects.failures).toEqual([]);
  });
});
