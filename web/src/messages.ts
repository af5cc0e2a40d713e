/** The protocol as this page uses it, and a check of what arrives. */
import type { Requests, ServerMessage, StateMessage } from "./protocol";

export const PROTOCOL = 3;

export type Method = keyof Requests;
/** Requests whose newest alone counts; they have no id and no answer. */
export type StreamMethod = "steer_joints" | "pose_joints";
/** Requests that are executed at the next tick, each of them, if they have no id. */
export type PostedMethod = "pull_link" | "speed_tool";
/** The params of a method; they can be left out if each of them has a default. */
export type Params<M extends Method> = object extends Requests[M]
  ? [params?: Requests[M]]
  : [params: Requests[M]];

/** A state of the robot with what the view has of it. */
export type Frame = StateMessage &
  Required<
    Pick<
      StateMessage,
      "position" | "velocity" | "effort" | "desired" | "objects" | "scene_number"
    >
  >;
/** What this page receives. */
export type Received = Exclude<ServerMessage, StateMessage> | Frame;

/** The members that this page reads, of each message. */
const NEEDED: Record<
  Received["type"],
  Record<string, "array" | "object" | "number">
> = {
  hello: { protocol: "number" },
  view: { robot: "object", missing: "object", notices: "array" },
  scene: { number: "number", objects: "array" },
  status: {
    controllers: "array",
    grippers: "array",
    poses: "array",
    targets: "object",
    control_boxes: "array",
    programs: "array",
  },
  state: {
    time: "number",
    position: "array",
    velocity: "array",
    effort: "array",
    desired: "array",
    objects: "array",
    scene_number: "number",
  },
  notice: { number: "number" },
  reply: {},
  goal_finished: {},
  fault: {},
  reset: {},
  overrun: {},
};

function kindOf(value: unknown): string {
  if (Array.isArray(value)) return "array";
  return value === null ? "null" : typeof value;
}

/** Return the message in `text`, or undefined if this page does not know it. */
export function parseMessage(text: unknown): Received | undefined {
  if (typeof text !== "string") return undefined;
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    return undefined;
  }
  if (kindOf(value) !== "object") return undefined;
  const message = value as Record<string, unknown>;
  const type = message["type"];
  if (typeof type !== "string" || !Object.hasOwn(NEEDED, type)) return undefined;
  const needed = NEEDED[type as Received["type"]];
  const complete = Object.entries(needed).every(
    ([name, kind]) => kindOf(message[name]) === kind,
  );
  return complete ? (message as unknown as Received) : undefined;
}
