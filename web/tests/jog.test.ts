import { beforeEach, describe, expect, it, vi } from "vitest";
import { connection, refusals } from "../src/connection";
import {
  drive,
  enable,
  endReason,
  goals,
  isDriving,
  watchDriving,
} from "../src/driving";
import { hold, letGo, release, watchJog } from "../src/jog";
import { toasts } from "../src/notices";
import { stopsAtObstacles } from "../src/planning/check";
import { chosenRobot } from "../src/robots";
import { silence, watchSilence } from "../src/silence";
import { FakeSocket, frame, sayTwoArms, status } from "./fixtures";
import { useFakeServer } from "./setup";

const UP = [0, 0, 1, 0, 0, 0] as const;

const server = () => FakeSocket.newest;
const arms = (method: string) =>
  server()
    .sentOf(method)
    .map(({ arm }) => arm);

const last = () => server().sentOf("speed_tool").at(-1)?.twist as number[] | undefined;

/** Let the page and the server go on for a while [ms]. */
const goOn = (duration = 50) => vi.advanceTimersByTimeAsync(duration);

async function answered(method: string): Promise<void> {
  await goOn(1);
  server().accept(method);
  await goOn(1);
}

describe("jogging", () => {
  useFakeServer();

  beforeEach(async () => {
    sayTwoArms(server());
    enable();
    const end = watchJog();
    await goOn(1);
    return () => {
      release("stick");
      void letGo();
      end();
    };
  });

  it("ends when another arm is selected", async () => {
    hold("stick", UP);
    await answered("take_arm");
    expect(arms("speed_tool")).toContain("left");
    chosenRobot.value = "right";
    await goOn();
    expect(arms("return_arm")).toEqual(["left"]);
    const before = arms("speed_tool").length;
    hold("stick", UP); // still held: it has to be released first
    await goOn();
    expect(arms("take_arm")).toEqual(["left"]);
    release("stick");
    hold("stick", UP);
    await answered("take_arm");
    await goOn();
    expect(arms("take_arm")).toEqual(["left", "right"]);
    expect(new Set(arms("speed_tool").slice(before))).toEqual(new Set(["right"]));
  });

  it("does not begin with an arm that was given back while it was taken", async () => {
    hold("stick", UP);
    await goOn(1);
    chosenRobot.value = "right";
    await answered("take_arm");
    await goOn();
    expect(arms("return_arm")).toEqual(["left"]);
    expect(arms("speed_tool")).toEqual([]);
  });

  it("does not go on by itself after it was halted", async () => {
    hold("stick", UP);
    await answered("take_arm");
    window.dispatchEvent(new Event("blur"));
    expect(last()).toEqual([0, 0, 0, 0, 0, 0]);
    hold("stick", UP); // still held
    await goOn();
    expect(last()).toEqual([0, 0, 0, 0, 0, 0]);
    release("stick");
    hold("stick", UP);
    await goOn();
    expect(last()?.[2]).toBeGreaterThan(0);
  });

  it("asks once for an arm that is refused, until the stick is released", async () => {
    hold("stick", UP);
    await goOn(1);
    server().refuse("take_arm", "the arm is off");
    for (let i = 0; i < 10; i++) {
      await goOn(16);
      hold("stick", UP);
    }
    expect(arms("take_arm")).toHaveLength(1);
    hold("stick", [0, 0, 0, 0, 0, 0]);
    hold("stick", UP);
    await goOn();
    expect(arms("take_arm")).toHaveLength(2);
  });

  it("does not go on by itself after a refusal", async () => {
    hold("stick", UP);
    await answered("take_arm");
    refusals.value += 1;
    await goOn();
    hold("stick", UP);
    await goOn();
    expect(arms("take_arm")).toHaveLength(1);
    expect(arms("return_arm")).toEqual(["left"]);
  });

  it("ends when the server falls silent, and takes another press after that", async () => {
    const endSilence = watchSilence();
    const endDriving = watchDriving();
    hold("stick", UP);
    await answered("take_arm");
    server().say(frame({ time: 1.1 }));
    await goOn(300);
    expect(isDriving.value).toBe(true);
    await goOn(500);
    expect([isDriving.value, endReason.value]).toEqual([false, "silent"]);
    expect(arms("return_arm")).toEqual(["left"]);
    const before = arms("speed_tool").length;
    for (let i = 1; i < 20; i++) {
      server().say(frame({ time: 1.1 + 0.05 * i })); // it answers again
      hold("stick", UP); // still held
      await goOn();
    }
    expect(silence.value).toBeNull();
    enable();
    hold("stick", UP);
    await goOn();
    expect(arms("speed_tool")).toHaveLength(before);
    expect(arms("take_arm")).toHaveLength(1);
    release("stick");
    hold("stick", UP);
    await answered("take_arm");
    expect(arms("speed_tool").length).toBeGreaterThan(before);
    endDriving();
    endSilence();
  });

  it("stops what may still be on its way to a silent server", async () => {
    const ends = [watchSilence(), watchDriving()];
    server().say(frame({ time: 11 }));
    void connection.request("go_to_pose", { name: "home" });
    await goOn(800);
    expect(endReason.value).toBe("silent");
    expect(server().sentOf("command_trajectory")).toHaveLength(1);
    for (const end of ends) end();
  });

  it("goes on when it begins anew after a refusal", async () => {
    hold("stick", UP);
    await answered("take_arm");
    refusals.value += 1;
    release("stick");
    hold("stick", UP);
    await answered("take_arm");
    server().say(status());
    await goOn();
    expect(arms("take_arm")).toHaveLength(2);
    expect(arms("return_arm")).toHaveLength(1);
  });

  describe("in front of obstacles", () => {
    beforeEach(() => {
      stopsAtObstacles.value = true;
      return () => {
        stopsAtObstacles.value = false;
      };
    });

    /** Answer the last look ahead. */
    async function sees(obstacle = ""): Promise<void> {
      const asked = server().sent.filter(({ method }) => method === "check_motion");
      const result = { is_free: obstacle === "", reason: obstacle };
      server().say({ type: "reply", id: asked.at(-1)?.id ?? null, result });
      await goOn(20);
    }

    it("begins when nothing is ahead, and stops when something is", async () => {
      hold("stick", UP);
      await answered("take_arm");
      await goOn(500);
      expect(arms("speed_tool")).toEqual([]);
      expect(server().sentOf("check_motion")).toMatchObject([
        { target: { arm: "left", pose: [{}, {}, [0, 0, 1, 0.025], {}] } },
      ]);
      await sees();
      expect(arms("speed_tool")).toEqual(["left"]);
      await goOn(150);
      expect(server().sentOf("check_motion")).toHaveLength(2);
      await sees("the wall");
      const twists = server().sentOf("speed_tool");
      expect(twists.at(-1)).toMatchObject({ twist: [0, 0, 0, 0, 0, 0] });
      expect(toasts.value[0]?.text).toContain("the wall");
      hold("stick", UP); // it has to be released first
      await goOn(500);
      expect(server().sentOf("speed_tool")).toHaveLength(twists.length);
    });

    it("stops while the server does not answer", async () => {
      hold("stick", UP);
      await answered("take_arm");
      await sees();
      await goOn(400);
      const before = arms("speed_tool").length;
      expect(before).toBeGreaterThan(5);
      await goOn(400);
      expect(arms("speed_tool")).toHaveLength(before);
      await sees();
      expect(arms("speed_tool").length).toBeGreaterThan(before);
    });

    it("lets a slider send only what is free", async () => {
      drive("pan", 0.6);
      drive("pan", 0.7); // while the first is looked at
      await sees();
      await sees();
      expect(server().sentOf("check_motion")).toMatchObject([
        { target: { positions: { pan: 0.6 } } },
        { target: { positions: { pan: 0.7 } } },
      ]);
      const sent = () => server().sentOf("steer_joints").at(-1);
      expect(sent()).toMatchObject({ positions: { pan: 0.7 } });
      drive("pan", 0.9);
      await sees("the wall");
      expect(sent()).toMatchObject({ positions: { pan: 0.7 } });
      expect(goals.value?.get("pan")?.value).toBe(0.7);
      expect(toasts.value[0]?.text).toContain("the wall");
    });
  });
});
