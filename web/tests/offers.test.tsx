/** What a robot does not offer is hidden, or disabled with the reason. */
import { act, render, screen } from "@testing-library/preact";
import { beforeEach, describe, expect, it } from "vitest";
import { enable } from "../src/driving";
import { MotionPanel } from "../src/panels/motion";
import { TopBar } from "../src/panels/top-bar";
import type { Method } from "../src/messages";
import { editByKey } from "../src/scene/edit-keys";
import { placing } from "../src/placing";
import { offers, unlessOffered, whyMissing } from "../src/store";
import { FakeSocket, frame, status, view } from "./fixtures";
import { useFakeServer } from "./setup";

const WHY = "this robot only follows joint paths";

/** Let the page show a robot that lacks these methods. */
function without(...methods: readonly Method[]): void {
  const missing = Object.fromEntries(methods.map((method) => [method, WHY]));
  FakeSocket.newest.say(view({ missing: { ...view().missing, ...missing } }));
  FakeSocket.newest.say(status({ poses: [] }));
  FakeSocket.newest.say(frame());
}

describe("what a robot offers", () => {
  useFakeServer();

  it("is nothing before there is a robot, and no control has a reason", () => {
    expect(offers("reset")).toBe(false);
    expect(whyMissing("reset")).toBe("");
    expect(unlessOffered("reset")).toEqual({});
  });

  it("is each method that is not missing, or one of several", () => {
    without("reset", "step");
    expect(offers("pause")).toBe(true);
    expect(offers("reset")).toBe(false);
    expect(offers("reset", "pause")).toBe(true);
    expect(offers("reset", "step")).toBe(false);
    expect(unlessOffered("pause")).toEqual({});
    expect(unlessOffered("reset")).toEqual({ disabled: true, title: WHY });
  });

  it("decides which keys of the scene do something", () => {
    without("add_object");
    expect(editByKey("a")).toBe(false);
    expect(placing.value).toBeNull();
  });
});

describe("the top bar", () => {
  useFakeServer();
  const title = (id: string) => screen.getByTestId(id).getAttribute("title");

  it("says why time cannot be changed, and hides recording", () => {
    without("pause", "reset", "set_speed", "start_recording", "emergency_stop");
    render(<TopBar />);
    for (const id of ["sim-pause", "sim-reset", "sim-speed", "estop"]) {
      expect(screen.getByTestId(id), id).toHaveProperty("disabled", true);
      expect(title(id), id).toBe(WHY);
    }
    expect(screen.queryByTestId("record-start")).toBeNull();
  });

  it("has every control of a robot that offers them", () => {
    without();
    render(<TopBar />);
    for (const id of ["sim-pause", "sim-reset", "sim-speed", "record-start", "estop"]) {
      expect(screen.getByTestId(id), id).toHaveProperty("disabled", false);
      expect(title(id), id).not.toBe("");
    }
  });
});

describe("the motion tab", () => {
  useFakeServer();
  beforeEach(() => {
    render(<MotionPanel />);
  });

  it("only shows joints that cannot be steered, and hides what has no method", async () => {
    await act(() => {
      without("steer_joints", "go_to_pose", "save_pose", "grip");
    });
    expect(document.querySelector(".joints.monitor")).not.toBeNull();
    expect(screen.queryByTestId("speed-scale")).toBeNull();
    expect(screen.queryByTestId("pose-name")).toBeNull();
  });

  it("keeps poses that can only be gone to", async () => {
    await act(() => {
      without("save_pose");
      const poses = [{ name: "home", positions: {}, saved: true, is_gripper: false }];
      FakeSocket.newest.say(status({ poses }));
      enable();
    });
    expect(screen.getByTestId("speed-scale")).not.toBeNull();
    expect(screen.queryByTestId("pose-name")).toBeNull();
    expect(screen.getByTestId("pose-go-home")).toHaveProperty("disabled", false);
  });
});
