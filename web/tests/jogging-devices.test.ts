import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { enable } from "../src/driving";
import { letGo, watchJog } from "../src/jog";
import { gamepad, watchGamepad } from "../src/jogging/gamepad";
import {
  connectSpaceMouse,
  deflections,
  disconnectSpaceMouse,
  spaceMouse,
} from "../src/jogging/spacemouse";
import { toasts } from "../src/notices";
import { FakeSocket, sayTwoArms } from "./fixtures";
import { useFakeServer } from "./setup";

const server = () => FakeSocket.newest;
const goOn = (duration = 50) => vi.advanceTimersByTimeAsync(duration);
const taken = () => server().sentOf("take_arm").length;

/** Return whether the tool moves now. */
async function moves(): Promise<boolean> {
  const before = server().sentOf("speed_tool").length;
  await goOn(100);
  const twists = server()
    .sentOf("speed_tool")
    .slice(before)
    .map(({ twist }) => twist as number[]);
  return twists.some((twist) => twist.some((speed) => speed !== 0));
}

async function isGiven(): Promise<void> {
  await goOn(50);
  server().accept("take_arm");
  await goOn(50);
}

function hide(isHidden: boolean): void {
  vi.spyOn(document, "hidden", "get").mockReturnValue(isHidden);
  document.dispatchEvent(new Event("visibilitychange"));
}

describe("a device that jogs", () => {
  useFakeServer();

  beforeEach(async () => {
    sayTwoArms(server());
    enable();
    const end = watchJog();
    await goOn(1);
    return () => {
      void letGo();
      end();
    };
  });

  afterEach(() => {
    vi.restoreAllMocks();
  });

  describe("a gamepad", () => {
    let pads: { -readonly [K in keyof Gamepad]?: Gamepad[K] }[];
    const [CENTRE, FORWARD] = [
      [0, 0, 0, 0],
      [0, -1, 0, 0],
    ];

    function press(index: number, isDown = true): void {
      const buttons = pads[0]?.buttons as unknown as { value: number }[];
      const button = buttons[index];
      if (button) button.value = isDown ? 1 : 0;
    }

    beforeEach(() => {
      const buttons = Array.from({ length: 17 }, () => ({ value: 0 }));
      const pad = { id: "Fake", index: 0, connected: true, mapping: "standard" };
      pads = [{ ...pad, axes: [...CENTRE], buttons } as unknown as Gamepad];
      Object.assign(navigator, { getGamepads: () => pads });
      const end = watchGamepad();
      return () => {
        end();
        Reflect.deleteProperty(navigator, "getGamepads");
      };
    });

    async function isPushed(): Promise<void> {
      await goOn();
      press(4);
      pads[0] = { ...pads[0], axes: FORWARD };
      await isGiven();
      expect(await moves()).toBe(true);
    }

    async function needsAFreshPush(): Promise<void> {
      expect(await moves()).toBe(false);
      pads[0] = { ...pads[0], axes: CENTRE };
      await goOn();
      pads[0] = { ...pads[0], axes: FORWARD };
      await goOn(1);
      if (taken() > 1) await isGiven();
      expect(await moves()).toBe(true);
    }

    it("moves the tool while its shoulder button is held", async () => {
      await goOn();
      pads[0] = { ...pads[0], axes: FORWARD };
      await goOn();
      expect(taken()).toBe(0);
      press(4);
      await isGiven();
      expect(await moves()).toBe(true);
      press(4, false);
      await goOn();
      expect(await moves()).toBe(false);
    });

    it("moves nothing by a stick that is held when it is found", async () => {
      press(4);
      pads[0] = { ...pads[0], axes: FORWARD };
      await goOn(200);
      expect(taken()).toBe(0);
    });

    it("stops when it is unplugged, and needs a fresh push after that", async () => {
      await isPushed();
      pads[0] = { ...pads[0], connected: false };
      await goOn();
      expect(await moves()).toBe(false);
      expect(gamepad.value).toBeNull();
      pads[0] = { ...pads[0], connected: true };
      await needsAFreshPush();
    });

    it("stops on a hidden page, and needs a fresh push after that", async () => {
      await isPushed();
      hide(true);
      await goOn();
      expect(await moves()).toBe(false);
      hide(false);
      await needsAFreshPush();
    });

    it("grips by a fresh press while its shoulder button is held", async () => {
      const grips = () => server().sentOf("grip");
      const [CLOSE, OPEN, SHOULDER] = [0, 1, 4];
      press(SHOULDER);
      press(CLOSE); // before it was found
      await goOn();
      expect(grips()).toEqual([]);
      press(CLOSE, false);
      await goOn();
      press(CLOSE);
      await goOn(200);
      expect(grips()).toMatchObject([{ gripper: "left_gripper", opening: 0 }]);
      press(OPEN);
      await goOn();
      expect(grips().slice(1)).toMatchObject([{ opening: 0.085 }]);
      press(OPEN, false);
      press(SHOULDER, false);
      await goOn();
      press(OPEN);
      await goOn();
      expect(grips()).toHaveLength(2);
    });

    it("does not grip by a button that was pressed on a hidden page", async () => {
      press(4);
      await goOn();
      hide(true);
      press(0);
      await goOn();
      hide(false);
      await goOn();
      expect(server().sentOf("grip")).toEqual([]);
    });

    it("is not used if the browser does not know its layout", async () => {
      pads[0] = { ...pads[0], mapping: "" };
      await goOn();
      expect(gamepad.value).toEqual({ name: "Fake", isUsed: false });
      press(4);
      pads[0] = { ...pads[0], axes: FORWARD };
      await goOn();
      expect(taken()).toBe(0);
      pads.push({
        ...pads[0],
        id: "Other",
        index: 1,
        mapping: "standard",
        axes: CENTRE,
      });
      await goOn();
      expect(gamepad.value).toEqual({ name: "Other", isUsed: true });
    });
  });

  describe("a SpaceMouse", () => {
    class FakeSpaceMouse extends EventTarget {
      readonly productName = "SpaceMouse Compact";
      readonly opened = false;
      open = vi.fn(() => Promise.resolve());
      close = () => Promise.resolve();

      /** Report where the cap is along its x. */
      push(count = 350): void {
        const data = new DataView(new ArrayBuffer(6));
        data.setInt16(0, count, true);
        this.dispatchEvent(
          Object.assign(new Event("inputreport"), { reportId: 1, data }),
        );
      }
    }
    let device: FakeSpaceMouse;

    beforeEach(() => {
      device = new FakeSpaceMouse();
      const hid = Object.assign(new EventTarget(), {
        requestDevice: () => Promise.resolve([device]),
      });
      Object.assign(navigator, { hid });
      return () => {
        disconnectSpaceMouse();
        Reflect.deleteProperty(navigator, "hid");
      };
    });

    it("begins by a push after a hidden page, not by one that is held", async () => {
      await connectSpaceMouse();
      hide(true);
      device.push();
      expect(taken()).toBe(0);
      hide(false);
      device.push();
      expect(taken()).toBe(0);
      device.push(0);
      device.push();
      expect(taken()).toBe(1);
    });

    it("begins by its first push, and stops when it is silent", async () => {
      await connectSpaceMouse();
      device.push();
      server().accept("take_arm");
      await goOn(1);
      device.push();
      expect(await moves()).toBe(true);
      expect(await moves()).toBe(false);
    });

    it("says why it cannot be opened", async () => {
      device.open.mockRejectedValue(new Error("permission denied"));
      await connectSpaceMouse();
      expect(spaceMouse.value).toBeNull();
      expect(toasts.value[0]?.text).toContain("permission denied");
    });

    it("has x forward, y left and z up, as a gamepad has", () => {
      const report = new DataView(new ArrayBuffer(12));
      const along = (index: number, count: number) => {
        for (let k = 0; k < 6; k++)
          report.setInt16(2 * k, k === index ? count : 0, true);
        return deflections(1, report, [0, 0, 0, 0, 0, 0]);
      };
      expect(along(1, -350)).toEqual([1, 0, 0, 0, 0, 0]);
      expect(along(0, -350)).toEqual([0, 1, 0, 0, 0, 0]);
      expect(along(2, -350)).toEqual([0, 0, 1, 0, 0, 0]);
      expect(along(4, -350)).toEqual([0, 0, 0, 1, 0, 0]);
      expect(along(3, -350)).toEqual([0, 0, 0, 0, 1, 0]);
      expect(along(5, -350)).toEqual([0, 0, 0, 0, 0, 1]);
    });
  });
});
