import { Object3D, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { fromRpy } from "../src/kinematics";
import type { Contact, ViewObject } from "../src/protocol";
import { touching } from "../src/scene/card";
import { forcesOf } from "../src/scene/contact-arrows";
import { boxOf } from "../src/scene/inertia";
import { reachOf } from "../src/scene/placer";
import { principalAxes } from "../src/scene/principal-axes";
import { LASTS, Trace } from "../src/scene/trace";
import { WrenchArrow } from "../src/scene/wrench-arrow";
import type { Vector } from "../src/urdf";

function object(name: string, mass: number | null): ViewObject {
  const shape = { kind: "box" as const, size: [1, 1, 1] as [number, number, number] };
  return { name, shape, rgba: [1, 0, 0, 1], mass, friction: 1 };
}

function contact(first: string, second: string, z: number): Contact {
  return { first, second, point: [0, 0, 0], force: [0, 0, z], torque: [0, 0, 0] };
}

describe("the forces at contacts", () => {
  const objects = [object("cube", 0.1), object("table", null)];
  const links = new Set(["pad"]);
  const shown = (...contacts: Contact[]) =>
    forcesOf(contacts, objects, links).map(({ on, by, force }) => [on, by, force[2]]);

  it("are those on what can be moved, whichever body comes first", () => {
    expect(shown(contact("cube", "table", -2))).toEqual([["cube", "table", 2]]);
    expect(shown(contact("table", "cube", 2))).toEqual([["cube", "table", 2]]);
    expect(shown(contact("pad", "cube", 3))).toEqual([["cube", "pad", 3]]);
    expect(shown(contact("pad", "ground", -4))).toEqual([["pad", "ground", 4]]);
  });

  it("are drawn by size, without those that nobody would see", () => {
    const all = [contact("pad", "cube", 1), contact("table", "cube", 5)];
    expect(shown(...all, contact("ground", "cube", 0.01))).toEqual([
      ["cube", "table", 5],
      ["cube", "pad", 1],
    ]);
  });

  it("are listed for each body", () => {
    const all = [contact("pad", "cube", 1), contact("cube", "table", -5)];
    expect(touching("cube", all)).toEqual([
      { other: "table", force: 5 },
      { other: "pad", force: 1 },
    ]);
    expect(touching("pad", all)).toEqual([{ other: "cube", force: 1 }]);
  });
});

describe("the wrench on a tool", () => {
  it("is in the axes of the tool", () => {
    const tip = new Object3D();
    tip.position.set(1, 2, 3);
    tip.rotation.set(Math.PI / 2, 0, 0); // its z is the root's -y
    tip.updateMatrixWorld(true);
    const arrow = new WrenchArrow();
    arrow.show(tip, [0, 0, 100, 0, 0, 0]);
    const [label] = arrow.labels;
    expect(label?.text).toBe("F 100.0 N, τ 0.00 N·m");
    expect(label?.at.toArray()).toEqual([
      expect.closeTo(1),
      expect.closeTo(2 - 0.3),
      expect.closeTo(3),
    ]);
    arrow.show(undefined, undefined);
    expect(arrow.labels).toEqual([]);
  });
});

describe("the trace of a point", () => {
  const at = (x: number): Vector => [x, 0, 0];

  it("has its places in order, and forgets old ones", () => {
    const trace = new Trace();
    for (let i = 0; i <= 20; i++) trace.push(i, at(0.1 * i));
    const xs = trace.path.filter((_, index) => index % 3 === 0);
    expect(xs).toHaveLength(LASTS + 1);
    expect(xs[0]).toBeCloseTo(1);
    expect(xs.at(-1)).toBeCloseTo(2);
  });

  it("takes no place twice, and begins anew after a reset", () => {
    const trace = new Trace();
    trace.push(5, at(0));
    expect(trace.push(5.1, at(0.0001))).toBe(false);
    trace.push(5.2, at(0.5));
    trace.push(0, at(0.7));
    expect(trace.path).toEqual([0.7, 0, 0]);
  });
});

describe("the box of a link's inertia", () => {
  it("is the box itself, if the link is one, however it is turned", () => {
    const [mass, a, b, c] = [2, 0.1, 0.2, 0.4];
    const moments = [b * b + c * c, a * a + c * c, a * a + b * b].map(
      (sum) => (mass * sum) / 12,
    );
    const R = fromRpy([0.4, -0.7, 1.9]);
    const entry = (i: 0 | 1 | 2, j: 0 | 1 | 2) =>
      ([0, 1, 2] as const).reduce<number>(
        (sum, k) => sum + R[i][k] * (moments[k] ?? 0) * R[j][k],
        0,
      );
    const row = (i: 0 | 1 | 2): Vector => [entry(i, 0), entry(i, 1), entry(i, 2)];
    const found = principalAxes([row(0), row(1), row(2)]);
    const size = [...boxOf(mass, found.moments)].sort((x, y) => x - y);
    expect(size).toEqual([a, b, c].map((edge) => expect.closeTo(edge, 6) as number));
    const { axes } = found;
    const column = (j: 0 | 1 | 2) => new Vector3(axes[0][j], axes[1][j], axes[2][j]);
    expect(column(0).clone().cross(column(1)).dot(column(2))).toBeCloseTo(1);
  });
});

describe("an object that the pointer places", () => {
  it("stands on the surface", () => {
    const up = new Vector3(0, 0, 1);
    const aslant = new Vector3(1, 0, 1).normalize();
    expect(reachOf({ kind: "box", size: [1, 1, 0.4] }, up)).toBeCloseTo(0.2);
    expect(reachOf({ kind: "box", size: [1, 1, 1] }, aslant)).toBeCloseTo(Math.SQRT1_2);
    expect(reachOf({ kind: "sphere", radius: 0.3 }, aslant)).toBeCloseTo(0.3);
    const can = { kind: "cylinder" as const, radius: 0.1, length: 0.6 };
    expect(reachOf(can, up)).toBeCloseTo(0.3);
    expect(reachOf(can, new Vector3(0, 1, 0))).toBeCloseTo(0.1);
  });
});
