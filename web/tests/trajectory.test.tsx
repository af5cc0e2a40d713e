import { act, fireEvent, render, screen } from "@testing-library/preact";
import { beforeEach, describe, expect, it, vi } from "vitest";
import {
  adopt,
  endReason,
  goals,
  holdStill,
  isDriving,
  watchDriving,
} from "../src/driving";
import { toasts } from "../src/notices";
import { DriveBar } from "../src/panels/drive-bar";
import { TrajectoryPanel } from "../src/panels/trajectory";
import type { Status } from "../src/protocol";
import { angleUnit } from "../src/units";
import { controller, FakeSocket, frame, joint, view, status } from "./fixtures";
import { useFakeServer } from "./setup";

const server = () => FakeSocket.newest;
const input = (id: string) => screen.getByTestId<HTMLInputElement>(id);

function enable(): void {
  fireEvent.click(screen.getByTestId("enable-toggle"));
}

function drag(name: string, value: number): void {
  fireEvent.input(input(`joint-slider-${name}`), { target: { value: String(value) } });
}

async function pass(milliseconds: number): Promise<void> {
  await act(async () => {
    await vi.advanceTimersByTimeAsync(milliseconds);
  });
}

/** The server says a status, and a frame in which the page looks at it. */
async function say(changes: Partial<Status>, time = 1): Promise<void> {
  await act(() => {
    server().say(status(changes));
    server().say(frame({ time }));
  });
}

describe("the trajectory panel", () => {
  useFakeServer();
  beforeEach(async () => {
    angleUnit.value = "rad";
    const end = watchDriving();
    server().say(view());
    server().say(status());
    server().say(frame());
    render(
      <>
        <DriveBar />
        <TrajectoryPanel />
      </>,
    );
    await pass(50);
    return end;
  });

  it("follows the robot until it is enabled", async () => {
    expect(input("joint-slider-pan").disabled).toBe(true);
    await act(() => {
      server().say(frame({ position: [1.25, 0], time: 1.1 }));
    });
    await pass(100);
    expect(input("joint-slider-pan").valueAsNumber).toBeCloseTo(1.25);
    expect(screen.getByTestId("joint-actual-pan").textContent).toBe("1.250");
  });

  it("sends nothing when it is enabled, and begins where the robot is wanted", async () => {
    enable();
    await pass(2000);
    expect(server().sent).toEqual([]);
    expect(input("joint-slider-pan").valueAsNumber).toBeCloseTo(0.5);
    expect(input("joint-slider-lift").valueAsNumber).toBeCloseTo(-0.99);
    expect(input("joint-slider-pan").disabled).toBe(false);
  });

  it("sends of a drag the newest, with every joint of the controller", async () => {
    enable();
    for (let step = 1; step <= 100; step++) drag("pan", step / 100);
    await pass(100);
    const steers = server().sentOf("steer_joints");
    expect(steers).toHaveLength(2);
    expect(steers.at(-1)).toEqual({
      controller: "arm",
      positions: { pan: 1, lift: -0.99 },
      speed: 0.5,
    });
  });

  const type = async (text: string, key = "Enter") => {
    const field = input("joint-field-pan");
    fireEvent.input(field, { target: { value: text } });
    fireEvent.keyDown(field, { key });
    await pass(50);
    return field;
  };
  const wanted = () =>
    server()
      .sentOf("steer_joints")
      .map(({ positions }) => (positions as { pan: number }).pan);

  it("takes the unit that is shown, and any other that is typed", async () => {
    angleUnit.value = "deg";
    await pass(50);
    enable();
    await pass(50);
    await type("90");
    await type("1.2rad");
    angleUnit.value = "rad";
    await pass(50);
    await type("45 deg");
    const expected = [Math.PI / 2, 1.2, Math.PI / 4];
    expect(wanted()).toHaveLength(3);
    wanted().forEach((pan, index) => {
      expect(pan).toBeCloseTo(expected[index] ?? NaN);
    });
  });

  it.each(["99", "-3.1", "180 deg", "12x"])(
    "moves nothing for %s, and says what would be right",
    async (text) => {
      enable();
      await pass(50);
      const field = await type(text);
      fireEvent.blur(field);
      await pass(50);
      expect(wanted()).toEqual([]);
      expect(field.value).toBe(text);
      expect(field.getAttribute("aria-invalid")).toBe("true");
      const problem = document.getElementById(
        field.getAttribute("aria-errormessage") ?? "",
      );
      expect(problem?.textContent).toMatch(/from -3.000 to 3.000 rad|a number of rad/);
      await type(text, "ArrowUp"); // from where it is
      expect(wanted()[0]).toBeCloseTo(0.51);
      expect(field.getAttribute("aria-invalid")).toBe("false");
    },
  );

  it("says why a motion was refused, and returns to where the robot goes", async () => {
    enable();
    drag("pan", 2);
    await pass(100);
    expect(input("joint-slider-pan").valueAsNumber).toBe(2);
    const message = "needs 56 rad/s, limit 3.14 rad/s";
    await act(() => {
      const error = { type: "ControlError", message };
      server().say({ type: "reply", id: null, error });
    });
    await pass(50);
    expect(toasts.value.map(({ severity, text }) => [severity, text])).toEqual([
      ["error", message],
    ]);
    expect(input("joint-slider-pan").valueAsNumber).toBe(0.5);
    expect(isDriving.value).toBe(true);
  });

  it("takes a limit as it is shown", async () => {
    const long = joint("pan", { upper: 3.14159265 });
    server().say(view({ robot: { ...view().robot, joints: [long, joint("lift")] } }));
    await say({});
    enable();
    await pass(50);
    await type("3.142");
    expect(wanted()).toEqual([3.14159265]);
  });

  it("steps by keys, ten times as far with Shift", async () => {
    enable();
    await pass(50);
    fireEvent.keyDown(input("joint-slider-pan"), { key: "ArrowRight" });
    await pass(50);
    fireEvent.keyDown(input("joint-slider-pan"), { key: "ArrowLeft", shiftKey: true });
    await pass(50);
    const steers = server().sentOf("steer_joints") as { positions: { pan: number } }[];
    expect(steers[0]?.positions.pan).toBeCloseTo(0.51);
    expect(steers[1]?.positions.pan).toBeCloseTo(0.41);
  });

  it("says value and unit to screen readers", async () => {
    enable();
    await pass(50);
    expect(input("joint-slider-pan").getAttribute("aria-valuetext")).toBe("0.500 rad");
  });

  it("ends driving for the emergency stop, and says so", async () => {
    enable();
    await say({ stopped: true });
    expect(goals.value).toBeNull();
    expect(endReason.value).toBe("stopped");
    expect(screen.getByTestId("driving-state").textContent).toContain("Driving ended");
  });

  it("leaves the sliders of a controller that stops, and takes them from there again", async () => {
    enable();
    drag("pan", 1);
    await say({ controllers: [controller({ state: "stopped" })] });
    expect(input("joint-slider-pan").disabled).toBe(true);
    server().sent.length = 0;
    await say({}, 1.1);
    await pass(100);
    expect(input("joint-slider-pan").valueAsNumber).toBeCloseTo(0.5);
    expect(server().sent).toEqual([]);
  });

  it("ends driving when time begins anew", async () => {
    enable();
    await say({}, 0.01);
    expect(endReason.value).toBe("reset");
  });

  it("ends driving when the connection is lost", async () => {
    enable();
    await act(() => {
      server().end();
    });
    expect(endReason.value).toBe("lost");
  });

  it("ends driving when somebody else sends the robot elsewhere for half a second", async () => {
    enable();
    drag("pan", 1);
    await pass(50);
    await say({ targets: { pan: 0.5, lift: -1 } }, 1.1);
    await pass(300);
    await say({ targets: { pan: 1, lift: -0.99 } }, 1.2);
    await pass(1000);
    await say({ targets: { pan: 1, lift: -0.99 } }, 1.3);
    expect(goals.value).not.toBeNull();
    await say({ targets: { pan: 2, lift: 0 } }, 1.4);
    await pass(600);
    await say({ targets: { pan: 2, lift: 0 } }, 1.5);
    expect(endReason.value).toBe("elsewhere");
    enable();
    await say({ targets: { pan: 2, lift: 0 } }, 1.6);
    expect(endReason.value).toBeNull();
  });

  it("blames nobody when a motion of its own ends short of its target", async () => {
    enable();
    adopt({ pan: 2, lift: 1 });
    await pass(2000);
    const stopped = { targets: { pan: 0.5, lift: -0.99 } };
    for (const time of [1.1, 1.2, 1.3, 1.4]) {
      await say(stopped, time); // where the robot is
      await pass(300);
    }
    expect(endReason.value).toBeNull();
    expect(input("joint-slider-pan").valueAsNumber).toBeCloseTo(0.5);
  });

  it("lets an aborted motion of its own end in peace, however slowly it stops", async () => {
    enable();
    adopt({ pan: 2, lift: 1 });
    await act(() => {
      const outcome = { status: "ABORTED", error_code: -4, error_string: "path" };
      server().say({ type: "goal_finished", goal: 1, controller: "arm", outcome });
    });
    for (const time of [1.1, 1.2, 1.3]) {
      await say({ targets: { pan: 0.7, lift: -0.9 } }, time);
      await pass(300);
    }
    await say({ targets: { pan: 0.5, lift: -0.99 } }, 1.4);
    await pass(600);
    await say({ targets: { pan: 0.5, lift: -0.99 } }, 1.5);
    expect(endReason.value).toBeNull();
  });

  it("takes what it wanted a while ago for its own: a busy server is late", async () => {
    enable();
    drag("pan", 1);
    await pass(100);
    drag("pan", 1.4);
    for (let time = 1.1; time < 2; time += 0.1) {
      await pass(300);
      await say({ targets: { pan: 1, lift: -0.99 } }, time);
    }
    expect(endReason.value).toBeNull();
    await pass(5000); // so late is nobody
    await say({ targets: { pan: 1, lift: -0.99 } }, 7);
    await pass(600);
    await say({ targets: { pan: 1, lift: -0.99 } }, 8);
    expect(endReason.value).toBe("elsewhere");
  });

  it("takes a pose and a stop of its own for its own", async () => {
    enable();
    adopt({ pan: 2, lift: 1, another: 7 });
    await say({ targets: { pan: 2, lift: 1 } }, 1.1);
    await pass(1000);
    await say({ targets: { pan: 2, lift: 1 } }, 1.2);
    expect(goals.value?.get("pan")?.value).toBe(2);
    void holdStill();
    expect(server().sentOf("command_trajectory")).toEqual([{ controller: "arm" }]);
    await say({ targets: { pan: 1.3, lift: 0 } }, 1.3);
    await pass(1000);
    await say({ targets: { pan: 1.31, lift: 0 } }, 1.4);
    await pass(1000);
    await say({ targets: { pan: 1.31, lift: 0 } }, 1.5);
    expect(goals.value?.get("pan")?.value).toBe(1.31);
  });

  it("lists who cannot be driven, with the reason", async () => {
    const undrivable = controller({ name: "efforts", undrivable: "has no limits" });
    await say({ controllers: [controller(), undrivable] });
    const option = screen.getByRole<HTMLOptionElement>("option", { name: /efforts/ });
    expect(option.disabled).toBe(true);
    expect(option.textContent).toContain("has no limits");
  });
});
