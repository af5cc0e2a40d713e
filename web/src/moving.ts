/** The object that the user is moving, and its new pose: one at a time. */
import { signal } from "@preact/signals";
import type { ErrorInfo } from "./protocol";
import { placeObject } from "./scene-edits";
import type { Vector } from "./urdf";

/** A pose in the form of requests: [m], and [rad] about fixed axes. */
export interface Target {
  readonly position: Vector;
  readonly rpy: Vector;
}

/** What the arrows in the scene do. */
export type MoveKind = "move" | "rotate";

export interface Move {
  readonly name: string;
  readonly kind: MoveKind;
  readonly target: Target;
  /** Why it could not be put there. */
  readonly problem: ErrorInfo | null;
}

/** By numbers in its row, or by the arrows in the scene; null while nothing is moved. */
export const moving = signal<Move | null>(null);

/** Start moving an object from its present pose, or end that with null. */
export function begin(
  name: string,
  target: Target | null,
  kind: MoveKind = "move",
): void {
  moving.value = target && { name, kind, target, problem: null };
}

/** Let the arrows move or rotate the object. */
export function setKind(kind: MoveKind): void {
  const now = moving.peek();
  if (now) moving.value = { ...now, kind };
}

/** Change its target; nothing is sent yet. */
export function aimAt(target: Target): void {
  const now = moving.peek();
  if (now) moving.value = { ...now, target };
}

/** Send the request. */
export async function putThere(): Promise<void> {
  const move = moving.peek();
  if (!move) return;
  const { name, target } = move;
  const problem = await placeObject(name, target);
  const now = moving.peek();
  if (now?.name === name) moving.value = { ...now, problem };
}
