import { act, fireEvent, render, screen } from "@testing-library/preact";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { isDriving, watchDriving } from "../src/driving";
import { Banners } from "../src/panels/banners";
import { Confirmation } from "../src/panels/confirmation";
import { ControllersPanel } from "../src/panels/controllers";
import { DriveBar } from "../src/panels/drive-bar";
import { MotionPanel } from "../src/panels/motion";
import { RobotBar } from "../src/panels/robot-bar";
import { layout } from "../src/plots/layout";
import type { GripperInfo, JointInfo, RobotPartsInfo, Status } from "../src/protocol";
import { robotOfLink } from "../src/robots";
import { angleUnit } from "../src/units";
import { parseUrdf } from "../src/urdf";
import { controller, FakeSocket, frame, joint, status, view } from "./fixtures";
import { useFakeServer } from "./setup";

const plotted = () => layout.value.flatMap((pane) => pane.map(({ id }) => id));
const server = () => FakeSocket.newest;
const find = (id: string) => screen.queryByTestId(id);
const input = (id: string) => screen.getByTestId<HTMLInputElement>(id);
const press = (id: string) => fireEvent.click(screen.getByTestId(id));

/** Its pan turns; its finger slides. */
function parts(name: string): RobotPartsInfo {
  return {
    name,
    title: name === "left" ? "ur5e + hande" : null,
    prefix: `${name}_`,
    base: `${name}_base`,
    joints: [`${name}_pan`, `${name}_finger`],
    gripper: name,
    tip: `${name}_tool0`,
  };
}

function jointsOf(name: string): JointInfo[] {
  const slides = { type: "prismatic", lower: 0, upper: 0.025 } as const;
  return [joint(`${name}_pan`), joint(`${name}_finger`, slides)];
}

function gripper(name: string): GripperInfo {
  return {
    name,
    joint: `${name}_finger`,
    max_opening: 0.05,
    min_speed: 0.02,
    max_speed: 0.15,
    min_force: 60,
    max_force: 130,
    ...{ pad_offset: 0.025, pad_cos: 0, pad_sin: 0, pad_slope: -1 },
  };
}

const cell = () =>
  view({
    robot: {
      ...view().robot,
      joints: [...jointsOf("left"), ...jointsOf("right")],
      grippers: [gripper("left"), gripper("right")],
      robots: [parts("left"), parts("right")],
    },
  });

const CONTROLLERS = [
  controller({
    name: "states",
    type: "joint_state_controller/JointStateController",
    role: "reader",
    interface: null,
    joints: [],
    undrivable: "only reads",
  }),
  ...["left", "right"].flatMap((name) => [
    controller({ name: `${name}_arm`, joints: [`${name}_pan`] }),
    controller({ name: `${name}_gripper`, joints: [`${name}_finger`] }),
  ]),
];
const POSITIONS = { left_pan: 0.1, left_finger: 0.01, right_pan: 0.2, right_finger: 0 };
const POSES = [
  { name: "both", saved: true, is_gripper: false, positions: POSITIONS },
  { name: "left only", saved: true, is_gripper: false, positions: { left_pan: 1 } },
];

async function pass(milliseconds: number): Promise<void> {
  await act(async () => {
    await vi.advanceTimersByTimeAsync(milliseconds);
  });
}

async function say(changes: Partial<Status>): Promise<void> {
  await act(() => {
    const now = { controllers: CONTROLLERS, poses: POSES, targets: POSITIONS };
    server().say(status({ ...now, ...changes }));
  });
}

function Page() {
  return (
    <>
      <Banners />
      <Confirmation />
      <DriveBar />
      <RobotBar />
      <MotionPanel />
      <ControllersPanel />
    </>
  );
}

/** Let the server find nothing in the way. */
async function wayIsFree(): Promise<void> {
  await pass(1);
  const asked = server().sent.filter(({ method }) => method === "check_motion");
  server().say({
    type: "reply",
    id: asked.at(-1)?.id ?? null,
    result: { is_free: true },
  });
  await pass(1);
}

describe("a single robot", () => {
  useFakeServer();

  it("has no selector, whole names, and requests without a robot", async () => {
    const robot = {
      ...cell().robot,
      robots: [parts("left")],
      joints: jointsOf("left"),
    };
    server().say(view({ robot }));
    await say({});
    render(<Page />);
    expect(find("robots")).toBeNull();
    expect(screen.getByTitle("left_pan").textContent).toBe("left_pan");
    expect(screen.queryByRole("heading", { name: "left" })).toBeNull();
    press("enable-toggle");
    await pass(50);
    press("pose-go-both");
    await wayIsFree();
    expect(server().sentOf("go_to_pose")).toEqual([{ name: "both", speed: 0.5 }]);
  });
});

describe("a cell of two robots", () => {
  useFakeServer();
  beforeEach(async () => {
    angleUnit.value = "rad";
    const end = watchDriving();
    server().say(cell());
    const position = Object.values(POSITIONS);
    const still = { velocity: [0, 0, 0, 0], effort: [0, 0, 0, 0] };
    server().say(frame({ position, desired: position, ...still }));
    await say({});
    render(<Page />);
    await pass(50);
    return end;
  });

  it("shows the joints, the gripper and the poses of the selected robot", async () => {
    expect(screen.getByTitle("left_pan").textContent).toBe("pan");
    expect(find("joint-slider-right_pan")).toBeNull();
    expect(screen.getByRole("region", { name: "left: Gripper" })).toBeTruthy();
    expect(plotted()).toEqual(["joint/left_pan/position"]);
    press("robot-right");
    await pass(50);
    expect(find("joint-slider-left_pan")).toBeNull();
    expect(input("joint-slider-right_pan").valueAsNumber).toBeCloseTo(0.2);
    expect(screen.getByRole("region", { name: "right: Gripper" })).toBeTruthy();
    expect(find("pose-go-both")).not.toBeNull();
    expect(find("pose-go-left only")).toBeNull();
    expect(plotted()).toEqual(["joint/right_pan/position"]);
  });

  it("is chosen from by arrow keys", async () => {
    fireEvent.keyDown(screen.getByTestId("robot-left"), { key: "ArrowRight" });
    await pass(50);
    expect(screen.getByTestId("robot-right").getAttribute("aria-checked")).toBe("true");
    expect(document.activeElement).toBe(screen.getByTestId("robot-right"));
    expect(screen.getByRole("radio", { name: "left: ur5e + hande" })).toBeTruthy();
  });

  it("drives only the selected robot, and stays driving when another is selected", async () => {
    press("enable-toggle");
    await pass(50);
    press("robot-right");
    await pass(50);
    expect(isDriving.value).toBe(true);
    expect(server().sent).toEqual([]);
    const slider = input("joint-slider-right_pan");
    fireEvent.input(slider, { target: { value: "1" } });
    await pass(100);
    press("pose-go-both");
    await wayIsFree();
    expect(server().sentOf("check_motion")).toMatchObject([
      {
        target: {
          arm: "right",
          positions: { right_pan: expect.any(Number) as number },
        },
      },
    ]);
    press("gripper-close");
    expect(server().sentOf("steer_joints")).toEqual([
      { controller: "right_arm", positions: { right_pan: 1 }, speed: 0.5 },
    ]);
    expect(server().sentOf("go_to_pose")).toEqual([
      { name: "both", speed: 0.5, robot: "right" },
    ]);
    expect(server().sentOf("grip")).toMatchObject([{ gripper: "right", opening: 0 }]);
  });

  it("remembers the controller of each robot", async () => {
    const select = () => input("controller-select");
    fireEvent.change(select(), { target: { value: "left_gripper" } });
    await pass(50);
    press("robot-right");
    await pass(50);
    expect(select().value).toBe("right_arm");
    press("robot-left");
    await pass(50);
    expect(select().value).toBe("left_gripper");
  });

  it("shows and takes the position of a sliding joint in millimetres", async () => {
    press("enable-toggle");
    await pass(50);
    fireEvent.change(input("controller-select"), { target: { value: "left_gripper" } });
    await pass(50);
    expect(input("joint-field-left_finger").value).toBe("10.0");
    expect(input("joint-slider-left_finger").max).toBe("25");
    fireEvent.input(input("joint-field-left_finger"), { target: { value: "20" } });
    fireEvent.keyDown(input("joint-field-left_finger"), { key: "Enter" });
    await pass(100);
    expect(server().sentOf("steer_joints")).toMatchObject([
      { positions: { left_finger: 0.02 } },
    ]);
  });

  it("saves and deletes poses of the selected robot", async () => {
    press("robot-right");
    await pass(50);
    fireEvent.input(screen.getByTestId("pose-name"), {
      target: { value: "left only" },
    });
    await pass(50);
    press("pose-save"); // adds to it, and overwrites nothing
    await pass(50);
    expect(server().sentOf("save_pose")).toEqual([
      { name: "left only", robot: "right" },
    ]);
    press("pose-delete-both");
    await pass(50);
    expect(screen.getByTestId("confirmation").textContent).toContain("of all robots");
  });

  it("lists all controllers, those of the selected robot first", async () => {
    const headings = () =>
      screen.getAllByRole("heading", { level: 3 }).map((one) => one.textContent);
    expect(headings()).toEqual(["left", "All robots", "right"]);
    press("robot-right");
    await pass(50);
    expect(headings()).toEqual(["right", "All robots", "left"]);
    for (const { name } of CONTROLLERS) {
      expect(find(`controller-row-${name}`)).not.toBeNull();
    }
  });

  it("reports a stall of the robot that is not selected, by its name", async () => {
    expect(find("robot-stalled-right")).toBeNull();
    await say({ stalls: [{ joint: "right_finger", effort: 130, contacts: [] }] });
    expect(find("robot-stalled-left")).toBeNull();
    expect(find("robot-stalled-right")).not.toBeNull();
    expect(screen.getByTestId("stall-banner").textContent).toContain(
      "right: finger pushes with 130 N ",
    );
  });

  it("knows the robot of each link", () => {
    const urdf = `<robot name="cell"><link name="world"/>${["left", "right"]
      .map(
        (name) => `<link name="${name}_base"/><link name="${name}_arm"/>
          <joint name="${name}_on" type="fixed"><parent link="world"/>
            <child link="${name}_base"/></joint>
          <joint name="${name}_pan" type="revolute"><parent link="${name}_base"/>
            <child link="${name}_arm"/></joint>`,
      )
      .join("")}</robot>`;
    const model = parseUrdf(urdf);
    expect(robotOfLink(model, "right_arm")?.name).toBe("right");
    expect(robotOfLink(model, "left_base")?.name).toBe("left");
    expect(robotOfLink(model, "world")).toBeUndefined();
  });
});
