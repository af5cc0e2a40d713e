import { beforeEach, describe, expect, it, vi } from "vitest";
import { model } from "../src/model";
import { frameName, meantTarget, shownTarget } from "../src/number-frame";
import * as store from "../src/store";
import { chosenFrame, jogsInTool, toolFrame } from "../src/tool";
import { parseUrdf } from "../src/urdf";
import { FakeSocket, frame, joint, view } from "./fixtures";
import { useFakeServer } from "./setup";
import { UR5 } from "./ur5";

const TARGET = { position: [0.5, 0.1, 0.2], rpy: [0.1, 0.2, 0.3] } as const;

describe("the frame of the numbers", () => {
  useFakeServer();

  beforeEach(async () => {
    chosenFrame.value = "world";
    jogsInTool.value = false;
    const robots = [
      {
        name: "arm",
        title: null,
        prefix: "",
        base: "base_link",
        joints: ["elbow_joint"],
        gripper: null,
        tip: "tool0",
      },
    ];
    const { robot } = view();
    const joints = [joint("elbow_joint")];
    FakeSocket.newest.say(
      view({ robot: { ...robot, root: "base_link", joints, robots } }),
    );
    await vi.advanceTimersByTimeAsync(50);
    model.value = parseUrdf(UR5);
    FakeSocket.newest.say(
      frame({ position: [0], velocity: [0], effort: [0], desired: [0] }),
    );
  });

  it("is the world at first, in which nothing is converted", () => {
    expect(frameName()).toBe("World");
    expect(shownTarget(TARGET)).toBe(TARGET);
  });

  it("is the base of a UR if the user wants it, on the opposite side", () => {
    expect(store.view.value?.robot.robots).toHaveLength(1);
    chosenFrame.value = "base";
    expect(frameName()).toBe("Base");
    const { position } = shownTarget(TARGET);
    expect(position).toEqual([-0.5, -0.1, 0.2]);
  });

  it("is left again by what the user types", () => {
    chosenFrame.value = "base";
    const { position, rpy } = meantTarget(shownTarget(TARGET));
    [...position, ...rpy].forEach((value, i) => {
      expect(value).toBeCloseTo([...TARGET.position, ...TARGET.rpy][i] ?? NaN, 8);
    });
  });

  it("has the axes of jogging, too, unless those are the tool's", () => {
    expect(toolFrame.value).toBe("world");
    chosenFrame.value = "base";
    expect(toolFrame.value).toBe("base");
    jogsInTool.value = true;
    expect(toolFrame.value).toBe("tool");
  });
});
