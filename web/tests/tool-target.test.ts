import { beforeEach, describe, expect, it, vi } from "vitest";
import { enable, selectRobot } from "../src/driving";
import { hold, letGo, release } from "../src/jog";
import { IDENTITY } from "../src/kinematics";
import type { Pose } from "../src/kinematics";
import type { Responses } from "../src/protocol";
import {
  aimTool,
  choosePosture,
  chosenBranch,
  collision,
  go,
  target,
  way,
} from "../src/tool-target";
import { FakeSocket, sayTwoArms } from "./fixtures";
import { useFakeServer } from "./setup";

const server = () => FakeSocket.newest;
const goOn = (duration = 50) => vi.advanceTimersByTimeAsync(duration);

function at(x: number): Pose {
  return { p: [x, 0, 0], R: IDENTITY.R };
}

/** Answer the last request for postures. */
async function solved(lift: number): Promise<void> {
  const result: Responses["solve_inverse_kinematics"] = [
    {
      positions: { pan: 0, lift },
      distance: 0,
      branch: { shoulder: "left", elbow: "up", wrist: "flip" },
    },
  ];
  const asked = server().sent.filter(
    ({ method }) => method === "solve_inverse_kinematics",
  );
  server().say({ type: "reply", id: asked.at(-1)?.id ?? null, result });
  await goOn();
}

/** Answer what would collide on the way. */
async function collides(...result: Responses["find_collisions"]): Promise<void> {
  await goOn(1);
  const asked = server().sent.filter(({ method }) => method === "find_collisions");
  server().say({ type: "reply", id: asked.at(-1)?.id ?? null, result });
  await goOn();
}

const CRASH = {
  ...{ first: "wrist_3_link", second: "table" },
  ...{ depth: 0.0123, begins: 0.8, depth_at_end: 0 },
};

/** Return where the robot was sent. */
function goals(): unknown[] {
  return [
    ...server()
      .sentOf("steer_joints")
      .map(({ positions }) => positions),
    ...server().sentOf("move_to"),
  ];
}

describe("the target of the tool", () => {
  useFakeServer();

  beforeEach(async () => {
    sayTwoArms(server());
    enable();
    await goOn(1);
  });

  it("is gone to when its postures are known, not those of the one before", async () => {
    aimTool(at(1));
    await solved(0.1);
    aimTool(at(2));
    void go();
    await goOn();
    expect(goals()).toEqual([]);
    await solved(0.2);
    await collides();
    expect(goals()).toEqual([{ pan: 0, lift: 0.2 }]);
  });

  it("is gone to at the second press where something would collide", async () => {
    aimTool(at(1));
    await solved(0.1);
    void go();
    await collides(CRASH);
    expect(collision.value).toMatchObject({ first: "wrist_3_link", second: "table" });
    void go(); // a double click
    await goOn();
    expect(goals()).toEqual([]);
    await goOn(500);
    void go();
    await goOn();
    expect(goals()).toEqual([{ pan: 0, lift: 0.1 }]);
    expect(collision.value).toBeNull();
  });

  it("is checked anew when it changes, and on a line at its end only", async () => {
    aimTool(at(1));
    await solved(0.1);
    void go();
    await collides(CRASH);
    aimTool(at(2));
    expect(collision.value).toBeNull();
    await solved(0.2);
    await goOn(500);
    void go();
    await collides(CRASH);
    expect(goals()).toEqual([]);
    way.value = "linear";
    void go();
    await collides(CRASH);
    expect(server().sentOf("move_linear")).toHaveLength(1);
    way.value = "joint";
  });

  it("is not gone to if it turns out to be unreachable", async () => {
    aimTool(at(1));
    await solved(0.1);
    aimTool(at(9));
    void go();
    server().refuse("solve_inverse_kinematics", "too far");
    await goOn();
    expect(goals()).toEqual([]);
  });

  it("is forgotten with its posture when another arm is selected", async () => {
    aimTool(at(1));
    await solved(0.1);
    choosePosture("left up flip");
    selectRobot("right");
    expect([target.value, chosenBranch.value]).toEqual([null, null]);
    void go();
    await goOn();
    expect(goals()).toEqual([]);
  });

  it("is forgotten even while the arm is given back to go there", async () => {
    hold("stick", [0, 0, 1, 0, 0, 0]);
    await goOn(1);
    server().accept("take_arm");
    await goOn(1);
    release("stick");
    aimTool(at(1));
    await solved(0.1);
    void go();
    await goOn(1);
    selectRobot("right");
    server().accept("return_arm");
    await goOn();
    expect(goals()).toEqual([]);
    void letGo();
  });
});
