/** Messages as they come off the wire: trusted only as far as the page would break without. */
import type { ClientMessage, PoseJoints, ServerMessage, Steer } from "./protocol";

export const PROTOCOL = 1;

export type StreamMessage = Steer | PoseJoints;
type WithoutId<T> = T extends { id: number } ? Omit<T, "id"> : never;
/** A request, before the connection numbers it. */
export type RequestMessage = WithoutId<Exclude<ClientMessage, StreamMessage>>;

/** The members without which the page could not go on, of each message. */
const NEEDED: Record<
  ServerMessage["type"],
  Record<string, "array" | "object" | "number">
> = {
  hello: { protocol: "number", robot: "object", notices: "array" },
  scene: { number: "number", objects: "array" },
  status: {
    controllers: "array",
    grippers: "array",
    poses: "array",
    targets: "object",
  },
  frame: {
    time: "number",
    position: "array",
    velocity: "array",
    desired: "array",
    objects: "array",
    scene: "number",
  },
  notice: { number: "number" },
  reply: {},
};

function kindOf(value: unknown): string {
  if (Array.isArray(value)) return "array";
  return value === null ? "null" : typeof value;
}

/** Return the message in `text`, or undefined if it is none that this page knows. */
export function parseMessage(text: unknown): ServerMessage | undefined {
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
  const needed = NEEDED[type as ServerMessage["type"]];
  const complete = Object.entries(needed).every(
    ([name, kind]) => kindOf(message[name]) === kind,
  );
  return complete ? (message as unknown as ServerMessage) : undefined;
}
