import { act, fireEvent, render, screen, within } from "@testing-library/preact";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { disable, enable } from "../src/driving";
import { KEYS as JOG_KEYS } from "../src/jogging/keys";
import { toasts } from "../src/notices";
import { Banners } from "../src/panels/banners";
import { Confirmation } from "../src/panels/confirmation";
import { EmergencyStop, engageOnEscape, leaveFullScreen } from "../src/panels/estop";
import Episodes from "../src/panels/episodes";
import { MotionPanel } from "../src/panels/motion";
import { Readings, RunButton, TimeControls } from "../src/panels/simulation";
import type { GripperInfo } from "../src/protocol";
import { shortcuts } from "../src/shortcuts";
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
  ...{ pad_offset: 0.0425, pad_cos: 0, pad_sin: 0, pad_slope: -1 },
};
const server = () => FakeSocket.newest;
const press = (id: string) => fireEvent.click(screen.getByTestId(id));

async function pass(milliseconds: number): Promise<void> {
  await act(async () => {
    await vi.advanceTimersByTimeAsync(milliseconds);
  });
}

/** Confirm what was asked. */
async function confirmed(): Promise<void> {
  await pass(500);
  press("confirmation-act");
  await pass(10);
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

  const engagements = () =>
    server()
      .sentOf("emergency_stop")
      .map(({ engaged }) => engaged);
  const stop = () =>
    act(() => {
      server().say(status({ stopped: true }));
    });

  it("is engaged by the button, however often it is pressed", async () => {
    press("estop");
    await stop();
    expect(screen.getByTestId("estop-banner").textContent).toContain("braked");
    press("estop");
    expect(engagements()).toEqual([true, true]);
  });

  it("has a name that begins with what it shows", () => {
    const button = screen.getByTestId("estop");
    expect(button.getAttribute("aria-label")).toContain(button.textContent);
  });

  it("is pressed once by a key that is held", () => {
    const held = { key: "Enter", repeat: true };
    // not done by default means: the browser does not click
    expect(fireEvent.keyDown(screen.getByTestId("estop"), held)).toBe(false);
  });

  it("says at once that it was requested, until the robot's state says more", async () => {
    press("estop");
    await pass(10);
    expect(screen.getByTestId("stop-requested").textContent).toContain("requested");
    await pass(5000);
    expect(screen.queryByTestId("stop-requested")).not.toBeNull();
    await stop();
    expect(screen.queryByTestId("stop-requested")).toBeNull();
  });

  const holds = [
    ["the pointer", "pointerDown", "pointerUp", { button: 0 }],
    ["Enter", "keyDown", "keyUp", { key: "Enter" }],
    ["the space bar", "keyDown", "keyUp", { key: " " }],
  ] as const;
  it.each(holds)("is released by %s, held for a second", async (_, down, up, event) => {
    await stop();
    const release = screen.getByTestId("estop-release");
    for (let click = 0; click < 5; click++) {
      fireEvent[down](release, event);
      await pass(250);
      fireEvent[up](release, event);
      await pass(100);
    }
    fireEvent.click(release);
    await pass(1000);
    expect(engagements()).toEqual([]);
    fireEvent[down](release, event);
    await pass(1000);
    expect(engagements()).toEqual([false]);
  });

  it("is not released by a key that was held before", async () => {
    await stop();
    const release = screen.getByTestId("estop-release");
    fireEvent.keyDown(release, { key: "Enter", repeat: true });
    await pass(1500);
    expect(engagements()).toEqual([]);
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

  const showFull = (element: Element | null) => {
    Object.assign(document, { fullscreenElement: element });
    document.dispatchEvent(new Event("fullscreenchange"));
  };

  it("is engaged by Escape that the browser takes to leave full screen", () => {
    showFull(document.body);
    expect(engagements()).toEqual([]);
    showFull(null);
    expect(engagements()).toEqual([true]);
  });

  it("is not engaged by the button that leaves full screen", () => {
    showFull(document.body);
    Object.assign(document, { exitFullscreen: () => Promise.resolve() });
    leaveFullScreen();
    showFull(null);
    expect(engagements()).toEqual([]);
  });

  it("is released only while the finger is on the button", async () => {
    await stop();
    const release = screen.getByTestId("estop-release");
    const dropped = vi.fn();
    release.hasPointerCapture = () => true;
    release.releasePointerCapture = dropped;
    fireEvent.pointerDown(release, { button: 0, pointerId: 7 });
    expect(dropped).toHaveBeenCalledWith(7);
    fireEvent.pointerLeave(release);
    await pass(1500);
    expect(engagements()).toEqual([]);
  });

  it("says that it could not be sent", async () => {
    server().end();
    press("estop");
    await pass(10);
    expect(screen.getByTestId("connection-banner").textContent).toContain("continues");
  });
});

describe("the keys of demonstrations", () => {
  useFakeServer();

  it("are none of jogging's", () => {
    render(<Episodes />);
    const codes = shortcuts.value
      .filter(({ text }) => text.startsWith("episodes."))
      .flatMap(({ keys }) => keys.map((key) => `Key${key.slice(-1).toUpperCase()}`));
    expect(codes).toHaveLength(4);
    expect(codes.filter((code) => code in JOG_KEYS)).toEqual([]);
  });
});

const POSES = [
  { name: "home", saved: false, is_gripper: false, positions: { pan: 0 } },
  { name: "open", saved: false, is_gripper: true, positions: { finger: 0 } },
  { name: "closed", saved: false, is_gripper: true, positions: { finger: 0.8 } },
];

describe("the gripper", () => {
  useFakeServer();
  beforeEach(() => {
    server().say(view({ robot: { ...view().robot, grippers: [GRIPPER] } }));
    server().say(status({ poses: POSES }));
    enable();
    render(<MotionPanel />);
  });

  const say = (
    motion: "moving" | "at_target" | "holding_inside",
    width: number | null,
  ) =>
    act(() => {
      const gobj = { moving: 0, at_target: 3, holding_inside: 2 }[motion];
      const state = { name: "gripper", opening: 0.0401, motion, gobj, width };
      server().say(status({ grippers: [state], poses: POSES }));
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

  it("and the poses move nothing while the page is read-only", async () => {
    await act(() => {
      disable();
    });
    for (const id of [
      "gripper-open",
      "gripper-close",
      "gripper-opening",
      "gripper-opening-field",
      "pose-go-home",
    ]) {
      expect(screen.getByTestId<HTMLButtonElement>(id).disabled).toBe(true);
    }
    expect(screen.getByTestId<HTMLButtonElement>("hold-still").disabled).toBe(false);
  });

  it("stands beside poses, whose refusal is a notice", async () => {
    press("pose-go-home");
    await act(async () => {
      server().refuse("go_to_pose", "a duration of at least 0.9 s");
      await vi.advanceTimersByTimeAsync(10);
    });
    expect(toasts.value.map(({ text }) => text)).toEqual([
      "a duration of at least 0.9 s",
    ]);
  });

  it("has poses of its own, which ask before they let go of what it holds", async () => {
    render(<Confirmation />);
    const sent = () =>
      server()
        .sentOf("go_to_pose")
        .map(({ name }) => name);
    const own = within(screen.getByRole("group", { name: "Gripper" }));
    expect(own.queryAllByRole("button").map((it) => it.textContent)).toEqual([
      "open",
      "closed",
    ]);
    await say("at_target", null);
    press("pose-go-open");
    await pass(10);
    expect(sent()).toEqual(["open"]);
    await say("holding_inside", 0.0401);
    press("pose-go-home");
    press("pose-go-closed");
    await pass(10);
    expect(sent()).toEqual(["open", "home", "closed"]);
    press("pose-go-open");
    await pass(10);
    expect(sent()).toHaveLength(3);
    await confirmed();
    expect(sent()).toEqual(["open", "home", "closed", "open"]);
  });

  it("stands beside poses that are overwritten and deleted once that is confirmed", async () => {
    const pose = { name: "mine", saved: true, is_gripper: false, positions: {} };
    render(<Confirmation />);
    await act(() => {
      server().say(status({ poses: [pose] }));
    });
    const name = screen.getByTestId("pose-name");
    for (const text of ["new", "mine"]) {
      fireEvent.input(name, { target: { value: text } });
      await pass(10);
      press("pose-save");
      await pass(10);
    }
    expect(server().sentOf("save_pose")).toEqual([{ name: "new" }]);
    await confirmed();
    expect(server().sentOf("save_pose")).toEqual([{ name: "new" }, { name: "mine" }]);
    press("pose-delete-mine");
    await pass(10);
    expect(server().sentOf("delete_pose")).toEqual([]);
    await confirmed();
    expect(server().sentOf("delete_pose")).toEqual([{ name: "mine" }]);
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

describe("a joint that pushes and does not move", () => {
  useFakeServer();

  it.each([
    [
      [["forearm_link", "table"]] as [string, string][],
      "lift pushes with 150 N·m against table (contact: forearm_link – table).",
    ],
    [[], "lift pushes with 150 N·m and does not move."],
  ])("is told with what it touches, %j", (contacts, text) => {
    server().say(view());
    server().say(status({ stalls: [{ joint: "lift", effort: -150, contacts }] }));
    render(<Banners />);
    expect(screen.getByTestId("stall-banner").textContent).toContain(text);
  });
});

describe("the simulation's readings", () => {
  useFakeServer();

  it.each([
    [1, 0.99, ""],
    [1, 0.8, "warning"],
    [10, 0.8, "warning"],
  ])("say at %fx and %fx real time how it keeps up", (speed, factor, tone) => {
    server().say(view());
    server().say(status({ speed, real_time_factor: factor, late_ticks: 12 }));
    render(<Readings />);
    expect(screen.getByTestId("sim-rtf").parentElement?.className).toBe(tone);
    expect(screen.getByTestId("sim-late").textContent).toBe("12/s");
  });
});

describe("the simulation's buttons", () => {
  useFakeServer();

  beforeEach(() => {
    server().say(view());
    server().say(status());
    render(
      <>
        <RunButton />
        <TimeControls />
        <Confirmation />
      </>,
    );
  });

  it("step only what is paused", async () => {
    expect(screen.getByTestId<HTMLButtonElement>("sim-step").disabled).toBe(true);
    press("sim-pause");
    await act(() => {
      server().say(status({ paused: true }));
    });
    press("sim-step");
    press("sim-resume");
    press("sim-reset");
    await confirmed();
    const methods = server().sent.map((request) => request.method);
    expect(methods).toEqual(["pause", "step", "resume", "reset"]);
  });

  it("asks with a button that is not ready in the first picture either", async () => {
    await pass(1000);
    let changes = 0;
    const observer = new MutationObserver((records) => {
      changes += records.length;
    });
    observer.observe(document.body, { subtree: true, attributeFilter: ["disabled"] });
    for (let k = 0; k < 2; k++) {
      press("sim-reset");
      await pass(10);
      await confirmed();
      await pass(1000);
    }
    observer.disconnect();
    expect(changes).toBe(2); // each time, it only becomes ready
    expect(server().sentOf("reset")).toHaveLength(2);
  });
});

describe("the view without physics", () => {
  useFakeServer();
  beforeEach(async () => {
    const joints = [joint("pan"), joint("lift", { mimics: "pan" })];
    server().say(
      view({ mode: "view", missing: {}, robot: { ...view().robot, joints } }),
    );
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
