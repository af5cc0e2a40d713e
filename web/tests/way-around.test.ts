import { beforeEach, describe, expect, it, vi } from "vitest";
import { disable, enable, goals } from "../src/driving";
import { toasts } from "../src/notices";
import { durationOf, pathOf, postureAt } from "../src/planning/plan";
import {
  discard,
  goThere,
  moveAnyway,
  moveAround,
  shownPosture,
  shownTime,
  wayAround,
} from "../src/planning/way-around";
import type { Plan } from "../src/protocol";
import { parseUrdf } from "../src/urdf";
import { FakeSocket, frame, sayTwoArms } from "./fixtures";
import { useFakeServer } from "./setup";

/** x = t³ (10 − 15 t + 6 t²): from rest to rest in a second, then back in two. */
const PLAN: Plan = {
  number: 7,
  joint_names: ["pan"],
  times: [0, 1, 3],
  positions: [[0.5], [1.5], [0.5]],
  velocities: [[0], [0], [0]],
  accelerations: [[0], [0], [0]],
  waypoints: [[0.5], [1.5], [0.5]],
  clearance: 0.012,
  nearest: "wrist_3_link and wall",
  is_direct: false,
  samples: 10,
  poses: 100,
  planning_time: 0.1,
};
const ROBOT = `<robot name="r"><link name="world"/><link name="arm"/><link name="tip"/>
  <joint name="pan" type="revolute"><parent link="world"/><child link="arm"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="end" type="fixed"><parent link="arm"/><child link="tip"/>
    <origin xyz="2 0 0"/></joint></robot>`;

const server = () => FakeSocket.newest;
const goOn = (duration = 1) => vi.advanceTimersByTimeAsync(duration);

/** Answer the last request of a method. */
async function answer(method: string, result: unknown): Promise<void> {
  await goOn();
  const asked = server().sent.filter((request) => request.method === method);
  server().say({ type: "reply", id: asked.at(-1)?.id ?? null, result });
  await goOn();
}

const move = vi.fn(() => Promise.resolve());
const moved = vi.fn();

function goes(): void {
  const there = { arm: "left", positions: { pan: 1 } };
  void goThere({ direct: there, isStraight: false, target: there, move, moved });
}

async function blocked(): Promise<void> {
  goes();
  await answer("check_motion", { is_free: false, reason: "the wall" });
}

async function planned(): Promise<void> {
  await blocked();
  await answer("plan_motion", PLAN);
}

describe("a plan", () => {
  it("follows quintics between its knots", () => {
    expect(postureAt(PLAN, -1)).toEqual({ pan: 0.5 });
    expect(postureAt(PLAN, 0.25)["pan"]).toBeCloseTo(0.5 + 0.103515625, 12);
    expect(postureAt(PLAN, 1)).toEqual({ pan: 1.5 });
    expect(postureAt(PLAN, 2)["pan"]).toBeCloseTo(1, 12);
    expect(postureAt(PLAN, 9)).toEqual({ pan: 0.5 });
    expect(durationOf(PLAN)).toBe(3);
  });

  it("meets velocities and accelerations of its knots", () => {
    // x = t² in three pieces of another size
    const times = [0, 0.5, 2, 3];
    const row = (value: (t: number) => number) => times.map((t) => [value(t)]);
    const square: Plan = {
      ...PLAN,
      times,
      positions: row((t) => t * t),
      velocities: row((t) => 2 * t),
      accelerations: row(() => 2),
    };
    for (const time of [0.1, 0.5, 1.3, 2.9]) {
      expect(postureAt(square, time)["pan"]).toBeCloseTo(time * time, 12);
    }
  });

  it("has the way of a link, from its begin to its end", () => {
    const path = pathOf(PLAN, parseUrdf(ROBOT), "tip", () => undefined);
    for (const end of [path[0], path.at(-1)]) {
      expect(end?.[0]).toBeCloseTo(2 * Math.cos(0.5), 9);
      expect(end?.[1]).toBeCloseTo(2 * Math.sin(0.5), 9);
    }
    expect(Math.max(...path.map(([, y]) => y))).toBeCloseTo(2 * Math.sin(1.5), 2);
  });
});

describe("going to a target", () => {
  useFakeServer();

  beforeEach(async () => {
    sayTwoArms(server());
    enable();
    move.mockClear();
    moved.mockClear();
    await goOn();
    return discard;
  });

  it("moves at once where the direct way is free", async () => {
    goes();
    expect(move).not.toHaveBeenCalled();
    await answer("check_motion", { is_free: true });
    expect(move).toHaveBeenCalledOnce();
    expect([wayAround.value, server().sentOf("plan_motion")]).toEqual([null, []]);
  });

  it("moves as before with an engine that cannot tell", async () => {
    goes();
    await goOn();
    server().refuse("check_motion", "no such shape");
    await goOn();
    expect(move).toHaveBeenCalledOnce();
  });

  it("is not ended by a part of the page that is loaded meanwhile", async () => {
    goes();
    await import("../src/tool-target");
    await answer("check_motion", { is_free: true });
    expect(move).toHaveBeenCalledOnce();
  });

  it("shows the way around, and moves on it when the user says so", async () => {
    await planned();
    expect(wayAround.value).toMatchObject({ state: "found", obstacle: "the wall" });
    expect(shownPosture.value).toEqual({ pan: 0.5 });
    shownTime.value = 1;
    expect(shownPosture.value).toEqual({ pan: 1.5 });
    expect(server().sentOf("execute_plan")).toEqual([]);
    void moveAround();
    await answer("execute_plan", []);
    expect(server().sentOf("execute_plan")).toEqual([{ number: 7 }]);
    expect([move.mock.calls, moved.mock.calls]).toEqual([[], [[]]]);
    expect([wayAround.value, shownPosture.value]).toEqual([null, null]);
    expect(goals.value?.get("pan")?.value).toBe(0.5); // the sliders are at its end
  });

  it("forgets a plan that the server refuses, with its reason", async () => {
    await planned();
    void moveAround();
    await goOn();
    server().refuse("execute_plan", "plan 7 starts elsewhere");
    await goOn();
    expect(wayAround.value).toBeNull();
    expect(toasts.value.map(({ text }) => text)).toEqual(["plan 7 starts elsewhere"]);
    expect(moved).not.toHaveBeenCalled();
  });

  it("goes anyway only where no way around was found", async () => {
    await planned();
    await moveAnyway();
    expect(move).not.toHaveBeenCalled();
    await blocked();
    server().refuse("plan_motion", "no way found in 5 s");
    await goOn();
    expect(wayAround.value).toMatchObject({
      state: "none",
      problem: "no way found in 5 s",
    });
    await moveAnyway();
    expect(move).toHaveBeenCalledOnce();
    expect(wayAround.value).toBeNull();
  });

  it("ends a search that is cancelled, or that another target replaces", async () => {
    await blocked();
    expect(wayAround.value?.state).toBe("searching");
    discard();
    await goOn();
    expect(server().sentOf("cancel_planning")).toHaveLength(1);
    server().refuse("plan_motion", "cancelled");
    await goOn();
    expect(wayAround.value).toBeNull();
    await blocked();
    goes();
    await answer("check_motion", { is_free: true });
    expect(server().sentOf("cancel_planning")).toHaveLength(2);
    expect(move).toHaveBeenCalledOnce();
  });

  it("neither moves nor shows a plan once Drive is off", async () => {
    goes();
    disable();
    await answer("check_motion", { is_free: true });
    expect(move).not.toHaveBeenCalled();
    enable();
    await planned();
    disable();
    expect(wayAround.value).toBeNull();
  });

  it("forgets a plan when the arm or an object has moved", async () => {
    await planned();
    server().say(frame({ time: 1.1, desired: [0.51, null] })); // it sags
    expect(wayAround.value?.state).toBe("found");
    server().say(frame({ time: 1.2, desired: [0.6, null] }));
    expect(wayAround.value).toBeNull();
    expect(toasts.value.at(-1)?.text).toContain("arm has moved");

    const cube = (time: number, x: number) =>
      frame({
        time,
        objects: [
          [
            [x, 0, 0],
            [1, 0, 0, 0],
          ],
        ],
      });
    server().say(cube(1.3, 1));
    await planned();
    server().say(cube(1.4, 1.001));
    expect(wayAround.value?.state).toBe("found");
    server().say(cube(1.5, 1.01));
    expect(wayAround.value).toBeNull();
    expect(toasts.value.at(-1)?.text).toContain("scene has changed");
  });
});
