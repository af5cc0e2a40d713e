/** Messages of a small robot, and a WebSocket of which the test is the other end. */
import type { Frame } from "../src/messages";
import type {
  ControllerInfo,
  GripperInfo,
  ViewInfo,
  JointInfo,
  RobotPartsInfo,
  ServerMessage,
  Status,
} from "../src/protocol";

export function joint(name: string, changes: Partial<JointInfo> = {}): JointInfo {
  return {
    name,
    type: "revolute",
    lower: -3,
    upper: 3,
    velocity: 3,
    effort: 150,
    driven: true,
    mimics: null,
    ...changes,
  };
}

export function controller(changes: Partial<ControllerInfo> = {}): ControllerInfo {
  return {
    name: "arm",
    type: "effort_controllers/JointTrajectoryController",
    role: "trajectory",
    state: "running",
    is_running: (changes.state ?? "running") === "running",
    interface: "effort",
    joints: ["pan", "lift"],
    undrivable: null,
    ...changes,
  };
}

export function view(changes: Partial<ViewInfo> = {}): ViewInfo {
  return {
    type: "view",
    mode: "simulation",
    engine: "mujoco",
    control_period: 0.001,
    grasp_assist: false,
    robot: {
      name: "two_joints",
      title: "two joints",
      root: "world",
      urdf: "/robot.urdf",
      ground: 0,
      joints: [joint("pan"), joint("lift")],
      grippers: [],
      robots: [],
      part_names: { pan: { en: "Base joint", zh: "底座关节" } },
    },
    cameras: [],
    missing: { pose_joints: "joints are set directly in `tool0 view` only" },
    notices: [],
    ...changes,
  };
}

function part(name: string): RobotPartsInfo {
  const prefix = `${name}_`;
  const tip = `${prefix}tool0`;
  const gripper = `${prefix}gripper`;
  return { name, title: null, prefix, base: "world", joints: [], gripper, tip };
}

function gripper(name: string): GripperInfo {
  return {
    name: `${name}_gripper`,
    joint: `${name}_finger_joint`,
    max_opening: 0.085,
    min_speed: 0.02,
    max_speed: 0.15,
    min_force: 20,
    max_force: 235,
    pad_offset: 0.0425,
    pad_cos: 0,
    pad_sin: 0,
    pad_slope: -0.05,
  };
}

/** Let the server of this page have two robots, `left` and `right`. */
export function sayTwoArms(server: FakeSocket): void {
  const now = view();
  const robots = [part("left"), part("right")];
  const grippers = [gripper("left"), gripper("right")];
  server.say({ ...now, robot: { ...now.robot, robots, grippers } });
  server.say(status());
  server.say(frame());
}

export function status(changes: Partial<Status> = {}): Status {
  return {
    type: "status",
    paused: false,
    stopped: false,
    fault: null,
    speed: 1,
    real_time_factor: 1,
    late_ticks: 0,
    clients: 1,
    controllers: [controller()],
    grippers: [],
    poses: [],
    stalls: [],
    targets: { pan: 0.5, lift: -1 },
    control_boxes: [],
    programs: [],
    ...changes,
  };
}

export function frame(changes: Partial<Frame> = {}): Frame {
  return {
    type: "state",
    time: 1,
    tick: 1000,
    position: [0.49, -0.99],
    velocity: [0, 0],
    effort: [0, 0],
    desired: [0.5, null],
    objects: [],
    scene_number: 0,
    ...changes,
  };
}

export interface SentRequest {
  readonly id?: number;
  readonly method: string;
  readonly params?: Record<string, unknown>;
}

export class FakeSocket extends EventTarget {
  static all: FakeSocket[] = [];
  readonly sent: SentRequest[] = [];
  bufferedAmount = 0;

  constructor(readonly url: string) {
    super();
    FakeSocket.all.push(this);
  }

  static get newest(): FakeSocket {
    const socket = FakeSocket.all.at(-1);
    if (!socket) throw new Error("nothing connected");
    return socket;
  }

  send(text: string): void {
    this.sent.push(JSON.parse(text) as SentRequest);
  }

  close(): void {
    this.end(1000);
  }

  /** Return the params of every request of a method. */
  sentOf(method: string): Record<string, unknown>[] {
    return this.sent
      .filter((request) => request.method === method)
      .map((request) => request.params ?? {});
  }

  /** Refuse the last request of a method. */
  refuse(method: string, message: string): void {
    const id =
      this.sent.filter((request) => request.method === method).at(-1)?.id ?? null;
    this.say({ type: "reply", id, error: { type: "ControlError", message } });
  }

  /** Carry out the last request of a method. */
  accept(method: string): void {
    const id =
      this.sent.filter((request) => request.method === method).at(-1)?.id ?? null;
    this.say({ type: "reply", id });
  }

  say(message: ServerMessage): void {
    this.sayText(JSON.stringify(message));
  }

  sayText(data: unknown): void {
    this.dispatchEvent(new MessageEvent("message", { data }));
  }

  end(code = 1006): void {
    this.dispatchEvent(new CloseEvent("close", { code }));
  }
}
