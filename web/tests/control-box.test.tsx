import { act, fireEvent, render, screen } from "@testing-library/preact";
import { beforeEach, describe, expect, it, vi } from "vitest";
import type { ControlBox } from "../src/control-box";
import { disable, enable } from "../src/driving";
import { toasts } from "../src/notices";
import { Banners } from "../src/panels/banners";
import { ControlBoxPanel } from "../src/panels/control-box";
import { FakeSocket, status, view } from "./fixtures";
import { useFakeServer } from "./setup";

function box(changes: Partial<ControlBox> = {}): ControlBox {
  return {
    arm: "arm",
    prefix: "",
    digital_inputs: Array.from({ length: 18 }, () => false),
    digital_outputs: Array.from({ length: 18 }, (_, pin) => pin === 17),
    analog_inputs: [
      { value: 2.5, domain: 1 },
      { value: 0.004, domain: 0 },
    ],
    analog_outputs: [
      { value: 0.012, domain: 0 },
      { value: 10, domain: 1 },
    ],
    tool_analog_inputs: [
      { value: 0, domain: 1 },
      { value: 0, domain: 1 },
    ],
    tool_voltage: 24,
    tool_current: 0,
    tool_temperature: 25,
    speed_slider: 0.8,
    speed_scaling: 0.8,
    payload: { mass: 1 },
    tcp: [0, 0, 0, 0, 0, 0],
    robot_mode: 7,
    safety_mode: 1,
    protective_stop: "",
    safety_limits: {},
    program: "PLAYING",
    taken_by: "",
    motion_failure: "",
    ur: null,
    link: null,
    ...changes,
  };
}

const server = () => FakeSocket.newest;
const press = (id: string) => fireEvent.click(screen.getByTestId(id));
const text = (id: string) => screen.getByTestId(id).textContent;
const isDisabled = (id: string) => screen.getByTestId<HTMLButtonElement>(id).disabled;
const show = (changes: Partial<ControlBox>) =>
  act(() => {
    server().say(status({ control_boxes: [box(changes)] }));
  });

describe("the control box", () => {
  useFakeServer();
  beforeEach(async () => {
    server().say(view());
    server().say(status({ control_boxes: [box()] }));
    enable();
    render(
      <>
        <Banners />
        <ControlBoxPanel />
      </>,
    );
    await act(async () => {
      await vi.advanceTimersByTimeAsync(10);
    });
  });

  it("shows modes and program", async () => {
    expect(text("robot-mode")).toBe("Running");
    expect(text("safety-mode")).toBe("Normal");
    expect(text("program-state")).toBe("Playing");
    await show({ robot_mode: 5, program: "STOPPED" });
    expect(text("robot-mode")).toBe("Idle, brakes on");
    expect(text("program-state")).toBe("Stopped");
    expect(isDisabled("power-on")).toBe(true);
    expect(isDisabled("program-play")).toBe(true);
    press("release-brakes");
    await show({ program: "STOPPED" });
    press("program-play");
    expect(server().sentOf("release_brakes")).toEqual([{ arm: "arm" }]);
    expect(server().sentOf("play_program")).toEqual([{ arm: "arm" }]);
  });

  it("shows a protective stop, and unlocks it", async () => {
    expect(screen.queryByTestId("protective-stop-banner")).toBeNull();
    await show({ safety_mode: 3, protective_stop: "too much force" });
    expect(text("protective-stop-banner")).toContain("too much force");
    expect(isDisabled("program-play")).toBe(true);
    press("unlock-arm");
    expect(server().sentOf("unlock_protective_stop")).toEqual([{ arm: "arm" }]);
    await act(async () => {
      server().refuse("unlock_protective_stop", "until 5s after occurrence");
      await vi.advanceTimersByTimeAsync(10);
    });
    expect(toasts.value.at(-1)?.text).toContain("5s after");
    await show({});
    expect(screen.queryByTestId("protective-stop-banner")).toBeNull();
  });

  it("sets inputs and shows outputs", async () => {
    press("pin-inputs-3");
    expect(server().sentOf("set_io")).toEqual([
      { arm: "arm", digital_inputs: { 3: true } },
    ]);
    expect(screen.getByTestId("pin-inputs-3").getAttribute("aria-label")).toBe(
      "Standard pin 3",
    );
    expect(screen.getByTestId("pin-outputs-17").getAttribute("aria-label")).toBe(
      "Tool pin 1: high",
    );
    expect(text("analog-output-0")).toBe("12.00 mA");
    expect(text("tool-voltage")).toBe("24 V");
    const field = screen.getByTestId("analog-input-1");
    fireEvent.input(field, { target: { value: "8" } });
    fireEvent.keyDown(field, { key: "Enter" });
    expect(server().sentOf("set_analog_input")).toEqual([
      { arm: "arm", pin: 1, value: 0.008, domain: 0, tool: false },
    ]);
    await act(() => {
      disable();
    });
    expect(isDisabled("pin-inputs-3")).toBe(true);
  });

  it("moves the speed slider", () => {
    const slider = screen.getByTestId("box-speed");
    fireEvent.keyDown(slider, { key: "ArrowLeft" });
    expect(server().sentOf("set_speed_slider")).toEqual([
      { arm: "arm", fraction: 0.79 },
    ]);
  });

  it("shows the program and the registers of UR's protocols", async () => {
    expect(screen.queryByTestId("ur-program")).toBeNull();
    const registers = { output_int_register_0: 2, input_double_register_1: 0.1 + 0.2 };
    await show({
      taken_by: "pick.script",
      ur: {
        program: "pick.script",
        program_state: "PLAYING",
        popup: "Place a part",
        clients: 2,
        registers,
      },
    });
    expect(text("ur-program")).toContain("pick.script");
    expect(text("ur-popup")).toBe("Place a part");
    expect(text("registers")).toContain("output_int_register_0");
    expect(text("registers")).toContain("0.3");
  });
});
