import { act, fireEvent, render, screen } from "@testing-library/preact";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { Banners } from "../src/panels/banners";
import { EmergencyStop, engageOnEscape } from "../src/panels/estop";
import { MotionPanel } from "../src/panels/motion";
import { Simulation } from "../src/panels/simulation";
import type { GripperInfo } from "../src/protocol";
import { FakeSocket, frame, view, joint, status } from "./fixtures";
import { useFakeServer } from "./setup";

const GRIPPER: GripperInfo = {
  name: "gripper",
  joint: "finger",
  max_opening: 0.085,
  min_speed: 0.02,
  max_speed: 0.15,
  min_force: 20,
  max_force: 235,
};
const server = () => FakeSocket.newest;
const press = (id: string) => fireEvent.click(screen.getByTestId(id));

async function pass(milliseconds: number): Promise<void> {
  await act(async () => {
    await vi.advanceTimersByTimeAsync(milliseconds);
  });
}

describe("the emergency stop", () => {
  useFakeServer();
  beforeEach(() => {
    server().say(view());
    server().say(status());
    render(
      <>
        <EmergencyStop />
        <Banners />
      </>,
    );
  });

  it("is engaged by the button, and released by it", async () => {
    press("estop");
    await act(() => {
      server().say(status({ stopped: true }));
    });
    expect(screen.getByTestId("estop-banner").textContent).toContain("braked");
    expect(screen.getByTestId("estop").textContent).toBe("Release");
    press("estop");
    expect(
      server()
        .sentOf("emergency_stop")
        .map(({ engaged }) => engaged),
    ).toEqual([true, false]);
  });

  it("is engaged by Escape, and never released by it", () => {
    server().say(status({ stopped: true }));
    engageOnEscape(new KeyboardEvent("keydown", { key: "Escape" }));
    engageOnEscape(new KeyboardEvent("keydown", { key: "Escape", repeat: true }));
    engageOnEscape(new KeyboardEvent("keydown", { key: "a" }));
    expect(
      server()
        .sentOf("emergency_stop")
        .map(({ engaged }) => engaged),
    ).toEqual([true]);
  });

  it("says that it could not be sent", async () => {
    server().end();
    press("estop");
    await pass(10);
    expect(screen.getByTestId("connection-banner").textContent).toContain("continues");
  });
});

describe("the gripper", () => {
  useFakeServer();
  beforeEach(() => {
    server().say(view({ robot: { ...view().robot, grippers: [GRIPPER] } }));
    render(<MotionPanel />);
  });

  const say = (
    motion: "moving" | "at_target" | "holding_inside",
    width: number | null,
  ) =>
    act(() => {
      const gobj = { moving: 0, at_target: 3, holding_inside: 2 }[motion];
      const state = { name: "gripper", opening: 0.0401, motion, gobj, width };
      server().say(status({ grippers: [state] }));
    });

  it("goes to an opening in millimetres, with the speed and force that were chosen", async () => {
    await say("at_target", null);
    fireEvent.input(screen.getByTestId("gripper-speed"), { target: { value: "50" } });
    fireEvent.input(screen.getByTestId("gripper-force"), { target: { value: "60" } });
    await pass(10);
    const field = screen.getByTestId("gripper-opening-field");
    fireEvent.input(field, { target: { value: "42.5" } });
    fireEvent.keyDown(field, { key: "Enter" });
    press("gripper-close");
    expect(server().sentOf("grip")).toMatchObject([
      { gripper: "gripper", opening: 0.0425, speed: 0.05, force: 60 },
      { gripper: "gripper", opening: 0, speed: 0.05, force: 60 },
    ]);
  });

  it("sends a drag once, at its end", async () => {
    await say("at_target", null);
    const slider = screen.getByTestId("gripper-opening");
    for (const value of ["80", "60", "40"])
      fireEvent.input(slider, { target: { value } });
    expect(server().sentOf("grip")).toEqual([]);
    fireEvent.change(slider);
    expect(server().sentOf("grip")).toMatchObject([{ opening: 0.04 }]);
  });

  it("says what it does, and why it refused", async () => {
    await say("holding_inside", 0.0401);
    expect(screen.getByTestId("gripper-state").textContent).toBe(
      "Holds an object 40.1 mm wide",
    );
    press("gripper-open");
    await act(async () => {
      server().refuse("grip", "no controller runs");
      await vi.advanceTimersByTimeAsync(10);
    });
    expect(screen.getByTestId("gripper-refusal").textContent).toBe(
      "no controller runs",
    );
  });
});

describe("the simulation's buttons", () => {
  useFakeServer();

  it("step only what is paused", async () => {
    server().say(view());
    server().say(status());
    render(<Simulation />);
    expect(screen.getByTestId<HTMLButtonElement>("sim-step").disabled).toBe(true);
    press("sim-pause");
    await act(() => {
      server().say(status({ paused: true }));
    });
    press("sim-step");
    press("sim-resume");
    press("sim-reset");
    const methods = server().sent.map((request) => request.method);
    expect(methods).toEqual(["pause", "step", "resume", "reset"]);
  });
});

describe("the view without physics", () => {
  useFakeServer();
  beforeEach(async () => {
    const joints = [joint("pan"), joint("lift", { mimics: "pan" })];
    server().say(view({ mode: "view", robot: { ...view().robot, joints } }));
    server().say(frame({ position: [0.3, 0.3] }));
    render(<MotionPanel />);
    await pass(50);
  });

  it("poses joints by sliders, but none that follows another", async () => {
    expect(screen.queryByTestId("joint-slider-lift")).toBeNull();
    const slider = screen.getByTestId<HTMLInputElement>("joint-slider-pan");
    expect(slider.valueAsNumber).toBeCloseTo(0.3);
    fireEvent.keyDown(slider, { key: "ArrowUp", shiftKey: true });
    await pass(50);
    fireEvent.keyDown(slider, { key: "ArrowUp", shiftKey: true });
    await pass(50);
    const poses = server().sentOf("pose_joints") as { positions: { pan: number } }[];
    expect(poses[0]?.positions.pan).toBeCloseTo(0.4);
    expect(poses[1]?.positions.pan).toBeCloseTo(0.5);
  });

  it("has the slider follow again after a person let it go", async () => {
    const slider = screen.getByTestId<HTMLInputElement>("joint-slider-pan");
    fireEvent.input(slider, { target: { value: "2" } });
    await pass(100);
    expect(slider.valueAsNumber).toBe(2);
    await pass(1000);
    expect(slider.valueAsNumber).toBeCloseTo(0.3);
  });

  it("goes to zero within the limits", () => {
    press("view-zero");
    expect(server().sentOf("pose_joints")).toMatchObject([{ positions: { pan: 0 } }]);
  });
});
