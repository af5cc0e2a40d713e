import { describe, expect, it } from "vitest";
import { placeOfDrop, sideOf } from "../src/panels/program/reorder";
import { poseAt } from "../src/program/checking";
import {
  inserted,
  moved,
  pathText,
  placeAfter,
  placeOf,
  removed,
  rowsOf,
  type Step,
  stepAt,
  type Way,
} from "../src/program/steps";

const note = (text: string): Step => ({ kind: "comment", text });
const loop = (...steps: Step[]): Step => ({ kind: "loop", times: 2, steps });

/** Return the steps as text: `a (b c) d`. */
function shown(steps: readonly Step[]): string {
  return steps
    .map((step) => {
      if (step.kind === "comment") return step.text;
      return step.kind === "loop" ? `(${shown(step.steps ?? [])})` : step.kind;
    })
    .join(" ");
}

const STEPS = [note("a"), loop(note("b"), note("c")), note("d")];

describe("the steps of a program", () => {
  it("are numbered as the server numbers them", () => {
    const paths = rowsOf(STEPS).map(({ path }) => pathText(path));
    expect(paths).toEqual(["1", "2", "2.1", "2.2", "3"]);
    expect(stepAt(STEPS, [2, 2])).toEqual(note("c"));
    expect(stepAt(STEPS, [1, 1])).toBeUndefined();
  });

  it("are inserted after the selected one, or into the selected loop", () => {
    const add = (path: readonly number[] | null) =>
      shown(inserted(STEPS, placeAfter(STEPS, path), note("x")));
    expect(add(null)).toBe("a (b c) d x");
    expect(add([1])).toBe("a x (b c) d");
    expect(add([2])).toBe("a (b c x) d");
    expect(add([2, 1])).toBe("a (b x c) d");
  });

  it("go where keys move them, and their path says where that is", () => {
    const go = (path: readonly number[], way: Way) => {
      const to = placeOf(STEPS, path, way);
      const found = to && moved(STEPS, path, to);
      return found && [shown(found.steps), pathText(found.path)];
    };
    expect(go([1], "down")).toEqual(["(b c) a d", "2"]);
    expect(go([3], "up")).toEqual(["a d (b c)", "2"]);
    expect(go([3], "in")).toEqual(["a (b c d)", "2.3"]);
    expect(go([2, 1], "out")).toEqual(["a (c) b d", "3"]);
    expect(go([1], "up")).toBeNull();
    expect(go([3], "down")).toBeNull();
    expect(go([1], "in")).toBeNull();
    expect(go([1], "out")).toBeNull();
  });

  it("stay in order, whatever is moved: what goes away and comes back is as before", () => {
    for (const { path } of rowsOf(STEPS)) {
      const step = stepAt(STEPS, path) ?? note("?");
      expect(inserted(removed(STEPS, path), path, step)).toEqual(STEPS);
    }
  });

  it("are not moved into themselves, and not too deep", () => {
    expect(moved(STEPS, [2], [2, 1])).toBeNull();
    let deep = loop();
    for (let depth = 1; depth < 10; depth++) deep = loop(deep);
    expect(moved([deep, loop(note("a"))], [1], [2, 1])).toBeNull();
  });

  it("are dropped before, after or into a row", () => {
    const row = { top: 100, height: 20 };
    expect(sideOf(row, 104, false)).toBe("before");
    expect(sideOf(row, 116, false)).toBe("after");
    expect(sideOf(row, 116, true)).toBe("into");
    expect(sideOf(row, 102, true)).toBe("before");
    const drop = (where: "before" | "after" | "into", from: readonly number[]) =>
      shown(moved(STEPS, from, placeOfDrop([2], where))?.steps ?? []);
    expect(drop("before", [3])).toBe("a d (b c)");
    expect(drop("into", [1])).toBe("(a b c) d");
    expect(drop("after", [1])).toBe("(b c) a d");
  });
});

describe("the preview of a plan", () => {
  const motion = {
    joint_names: ["pan"],
    times: [0, 1, 3],
    positions: [[0], [1], [2]],
    points: [],
    steps: [],
  };

  it("is between two postures, and stays at its ends", () => {
    expect(poseAt(motion, 0.5)).toEqual({ pan: 0.5 });
    expect(poseAt(motion, 2)).toEqual({ pan: 1.5 });
    expect(poseAt(motion, -1)).toEqual({ pan: 0 });
    expect(poseAt(motion, 9)).toEqual({ pan: 2 });
  });
});
