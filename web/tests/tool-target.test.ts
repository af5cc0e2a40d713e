import { beforeEach, describe, expect, it, vi } from "vitest";
import { enable, selectRobot } from "../src/driving";
import { hold, letGo, release } from "../src/jog";
import { IDENTITY } from "../src/kinematics";
import type { Pose } from "../src/kinematics";
import { discard } from "../src/planning/way-around";
import type { Responses } from "../src/protocol";
import {
  aimTool,
  choosePosture,
  chosenBranch,
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

/** Answer whether the way is free. */
async function checked(obstacle = ""): Promise<void> {
  await goOn(1);
  const asked = server().sent.filter(({ method }) => method === "check_motion");
  const result = { is_free: obstacle === "", reason: obstacle };
  server().say({ type: "reply", id: asked.at(-1)?.id ?? null, result });
  await goOn();
}

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
    await checked();
    expect(goals()).toEqual([{ pan: 0, lift: 0.2 }]);
  });

  it("is gone around to in any posture, unless the user chose one", async () => {
    aimTool(at(1));
    await solved(0.1);
    void go();
    await checked("the table");
    expect(goals()).toEqual([]);
    expect(server().sentOf("plan_motion")[0]).toMatchObject({
      targets: [{ arm: "left", pose: [[1, 0, 0, 1], {}, {}, {}] }],
    });
    choosePosture("left up flip");
    void go();
    await checked("the table");
    expect(server().sentOf("plan_motion")[1]).toMatchObject({
      targets: [{ arm: "left", positions: { pan: 0, lift: 0.1 } }],
    });
    choosePosture(null);
    discard();
  });

  it("is checked on the line that the tool moves on", async () => {
    way.value = "linear";
    aimTool(at(1));
    await solved(0.1);
    void go();
    await checked();
    expect(server().sentOf("check_motion").at(-1)).toMatchObject({
      linear: true,
      target: { pose: [[1, 0, 0, 1], {}, {}, {}] },
    });
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
