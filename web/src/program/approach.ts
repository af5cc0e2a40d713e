/** The way to where a program begins, while the user holds a button. */
import { effect, signal } from "@preact/signals";
import { connection } from "../connection";
import { adopt, holdStill, mayMove } from "../driving";
import { frames } from "../frames";
import { letGo } from "../jog";
import type { PlannedMotion, Program } from "../protocol";
import { report } from "../notices";
import { plannedPose } from "../scene/planned-pose";
import { jointIndex } from "../store";
import { program } from "./editor";
import { isMove, samePath, type Step, stepAt } from "./steps";

/** Joint → position [rad]. */
type Posture = Readonly<Record<string, number>>;

/** Of each joint's largest velocity. */
const SPEED = 0.2;
/** The arm is at the start within this [rad]. */
const NEAR = 0.02;
/** It has arrived, when it rests within this [rad], [rad/s]. */
const ARRIVED = 0.01;
const RESTING = 2e-3;

/** Where the program begins, while the arm is elsewhere and the user is asked. */
export const start = signal<Posture | null>(null);
/** A blended first move ends elsewhere each time: where the user has brought the arm counts. */
let reached: { of: Program; at: Posture } | null = null;
let isHeld = false;

/** Return where the first move of a plan goes, if it is one to a target. */
export function startOf(
  { joint_names: names, positions, steps: paths }: PlannedMotion,
  steps: readonly Step[],
): Posture | null {
  const [first] = paths;
  if (first === undefined) return null;
  const step = stepAt(steps, first);
  if (!isMove(step)) return null;
  const last = paths.map((path) => samePath(path, first)).lastIndexOf(true);
  const goal = positions[last] ?? [];
  return Object.fromEntries(names.map((name, i) => [name, goal[i] ?? 0]));
}

function isWithin(posture: Posture, tolerance: number): boolean {
  return Object.entries(posture).every(([joint, wanted]) => {
    const q = frames.latest?.position[jointIndex.peek().get(joint) ?? -1];
    return q !== undefined && Math.abs(q - wanted) < tolerance;
  });
}

/** Return whether the program can begin; if the arm is elsewhere, the user is asked. */
export function isAtStart(motion: PlannedMotion, of: Program): boolean {
  const wanted = startOf(motion, of.steps ?? []);
  const isThere =
    wanted === null ||
    isWithin(wanted, NEAR) ||
    (reached?.of === of && isWithin(reached.at, NEAR));
  start.value = isThere ? null : wanted;
  if (!isThere) plannedPose.value = wanted;
  return isThere;
}

/** Ask no longer. */
export function forgetStart(): void {
  start.value = null;
}

program.subscribe(forgetStart);
// a button that is disabled hears no release
effect(() => {
  if (!mayMove.value) endApproach();
});

/** Move to the start for as long as the button is held. */
export async function approach(): Promise<void> {
  const positions = start.peek();
  if (positions === null || !mayMove.peek()) return;
  isHeld = true;
  await letGo();
  if (!isStillHeld()) return;
  const problem = await connection.request("move_joints", {
    positions: { ...positions },
    speed: SPEED,
  });
  if (problem === null) {
    adopt(positions);
    return;
  }
  isHeld = false;
  report("error", problem.message);
}

/** Whether it is held after a wait, in which the user may have released it. */
function isStillHeld(): boolean {
  return isHeld;
}

/** Stop where the arm is. */
export function endApproach(): void {
  if (!isHeld) return;
  isHeld = false;
  void holdStill();
}

frames.listen(({ velocity }) => {
  const at = start.peek();
  if (at === null || velocity.some((v) => Math.abs(v) > RESTING)) return;
  if (!isWithin(at, ARRIVED)) return;
  isHeld = false;
  reached = { of: program.peek(), at };
  forgetStart();
});
