import { act, fireEvent, render, screen } from "@testing-library/preact";
import { expect, test, vi } from "vitest";
import { Confirmation } from "../src/panels/confirmation";
import { RealRobotBar } from "../src/panels/real-robot-bar";
import type { ControlBoxState } from "../src/protocol";
import { FakeSocket, status, view } from "./fixtures";
import { useFakeServer } from "./setup";

useFakeServer();

const LINK = {
  address: "192.168.1.10",
  model: "UR5",
  serial_number: "2019",
  software: "5.11.0",
  is_connected: true,
  is_remote: true,
  is_enabled: false,
  obstacles: ["the robot is under local control"],
};

function show(link: Partial<typeof LINK> = {}, failure = ""): void {
  FakeSocket.newest.say(view({ mode: "hardware" }));
  const box = {
    arm: "arm",
    prefix: "",
    payload: { mass: 1 },
    speed_slider: 0.25,
    motion_failure: failure,
    program: link.is_enabled === true ? "PLAYING" : "STOPPED",
    link: { ...LINK, ...link },
  } as ControlBoxState;
  FakeSocket.newest.say(status({ control_boxes: [box] }));
}

test("a simulated robot has no bar", () => {
  FakeSocket.newest.say(view());
  render(<RealRobotBar />);
  expect(screen.queryByTestId("real-robot")).toBeNull();
});

test("it says which robot it is, and what keeps it from moving", () => {
  show();
  render(<RealRobotBar />);
  const bar = screen.getByTestId("real-robot");
  expect(bar.textContent).toContain("REAL ROBOT");
  expect(bar.textContent).toContain("UR5 2019 · 192.168.1.10 · PolyScope 5.11.0");
  expect(bar.textContent).toContain("the robot is under local control");
  expect(bar.textContent).toContain("safety system is the only safety function");
});

test("motion is enabled after a question that names the robot", async () => {
  show({ obstacles: [] });
  render(
    <>
      <RealRobotBar />
      <Confirmation />
    </>,
  );
  fireEvent.click(screen.getByTestId("real-robot-enable"));
  const dialog = screen.getByTestId("confirmation");
  expect(dialog.textContent).toContain("UR5 2019 at 192.168.1.10");
  const confirming = screen.getByTestId<HTMLButtonElement>("confirmation-act");
  await act(async () => {
    await vi.advanceTimersByTimeAsync(500);
  });
  expect(confirming.disabled).toBe(false);
  fireEvent.click(confirming);
  expect(FakeSocket.newest.sentOf("enable_motion")).toEqual([
    { arm: "arm", serial_number: "2019" },
  ]);
});

test("it says why the arm came to rest, and offers to hold it again", () => {
  show({ is_enabled: true }, "the robot did not hear of tool0 for 0.1 s");
  render(<RealRobotBar />);
  const state = screen.getByTestId("real-robot-state");
  expect(state.textContent).toContain("25 % speed");
  expect(state.textContent).toContain("did not hear of tool0");
});

test("a lost link disables it", () => {
  show({ is_connected: false });
  render(<RealRobotBar />);
  const enable = screen.getByTestId<HTMLButtonElement>("real-robot-enable");
  expect(enable.disabled).toBe(true);
});
