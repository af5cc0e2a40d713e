import { afterEach, beforeEach, describe, expect, it } from "vitest";
import { startOf } from "../src/program/approach";
import type { PlannedMotion } from "../src/protocol";
import type { Step } from "../src/program/steps";
import { detailOf } from "../src/program/words";
import { angleUnit } from "../src/units";

const MOTION: PlannedMotion = {
  joint_names: ["a", "b"],
  times: [0, 1, 2, 3],
  positions: [
    [0, 0],
    [0.5, 1],
    [1, 2],
    [9, 9],
  ],
  points: [],
  steps: [[1], [1], [1], [2]],
};
const MOVE: Step = { kind: "move_joint", named_pose: "home" };

describe("where a program begins", () => {
  it("is the target of its first move", () => {
    expect(startOf(MOTION, [MOVE, MOVE])).toEqual({ a: 1, b: 2 });
  });

  it("is where the arm is, if it searches first, or does not move", () => {
    const search: Step = { kind: "until", direction: [0, 0, -1], distance: 0.1 };
    expect(startOf(MOTION, [search, MOVE])).toBeNull();
    const none = { ...MOTION, times: [], positions: [], steps: [] };
    expect(startOf(none, [{ kind: "wait", duration: 1 }])).toBeNull();
  });
});

describe("the row of a step", () => {
  const before = angleUnit.peek();
  beforeEach(() => {
    angleUnit.value = "rad";
  });
  afterEach(() => {
    angleUnit.value = before;
  });

  it("names a waypoint as the user does", () => {
    const named: Step = { kind: "move_joint", joints: { a: 1 }, label: "above cube" };
    expect(detailOf(named)).toBe("above cube · 1.05 rad/s");
  });

  it("tells the force of a grip", () => {
    expect(detailOf({ kind: "gripper", opening: "closed", force: 40 })).toBe(
      "closed · 40 N",
    );
    expect(detailOf({ kind: "gripper", opening: "closed" })).toBe("closed");
  });
});
