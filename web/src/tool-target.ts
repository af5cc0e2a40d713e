/** Where the tool is to go: a pose from the gizmo or from numbers, and the postures that reach it. */
import { computed, effect, signal } from "@preact/signals";
import { onChange } from "./changes";
import { connection } from "./connection";
import { driveTo, followPlan, isDriving, mayMove, speedScale } from "./driving";
import { frames } from "./frames";
import { letGo } from "./jog";
import { matrixOf } from "./kinematics";
import type { Pose } from "./kinematics";
import { report } from "./notices";
import { discard, goThere } from "./planning/way-around";
import type { Branch } from "./protocol";
import { plannedPose } from "./scene/planned-pose";
import { view } from "./store";
import { arm } from "./tool";
import { remembered } from "./ui/memory";

export interface Posture {
  readonly positions: Readonly<Record<string, number>>;
  readonly branch: Branch;
}

/** Of a tool that has arrived and rests [rad/s]. */
const RESTING = 2e-3;
/** So long without motion after a command, and the target is forgotten [simulated s]. */
const FORGET_AFTER = 0.7;
/** Of a straight motion at the full speed of the sliders [m/s]. */
const FASTEST = 0.5;

/** When the robot follows the gizmo. */
export const MOVES = ["release", "live"] as const;
export const gizmoMoves = remembered("gizmo-moves", MOVES, "release");
/** How it goes there. */
export const WAYS = ["joint", "linear"] as const;
export const way = remembered("tool-way", WAYS, "joint");
export const showGizmo = signal(false);

/** In the root; null: the fields and the gizmo follow the tool. */
export const target = signal<Pose | null>(null);
/** The postures that reach it, the nearest first. */
export const postures = signal<readonly Posture[]>([]);
/** Why it cannot be reached. */
export const unreachable = signal<string | null>(null);
/** The branch that the user chose, as `nameOf` writes it; null for the nearest. */
export const chosenBranch = signal<string | null>(null);

export const posture = computed<Posture | null>(
  () =>
    postures.value.find(({ branch }) => nameOf(branch) === chosenBranch.value) ??
    postures.value[0] ??
    null,
);

let solving: Promise<void> | null = null;
let isStale = false;
let isDragged = false;
let isCommanded = false;
let movedAt = 0;

/** Return what tells a branch from the others. */
export function nameOf({ shoulder, elbow, wrist }: Branch): string {
  return [shoulder, elbow, wrist].join(" ");
}

/** Change the target; nothing moves yet. */
export function aimTool(pose: Pose): void {
  discard();
  target.value = pose;
  isCommanded = false;
  void solve();
}

/** Forget the target: fields and gizmo follow the tool again. */
export function forgetTarget(): void {
  discard();
  clear();
}

function clear(): void {
  target.value = null;
  postures.value = [];
  unreachable.value = null;
  isCommanded = false;
}

/** Choose another posture, or the nearest with null. */
export function choosePosture(branch: string | null): void {
  chosenBranch.value = branch;
  discard();
}

/** Find the postures of the newest target, one request at a time. */
function solve(): Promise<void> {
  isStale = true;
  solving ??= solveAll().finally(() => {
    solving = null;
  });
  return solving;
}

async function solveAll(): Promise<void> {
  while (isStale) {
    isStale = false;
    const pose = target.peek();
    if (pose !== null) await solveOnce(pose);
  }
}

async function solveOnce(pose: Pose): Promise<void> {
  const answer = await connection.ask("solve_inverse_kinematics", {
    arm: arm.peek()?.name ?? null,
    pose: matrixOf(pose),
  });
  if (target.peek() === null) return;
  if (answer.problem !== null) {
    postures.value = [];
    unreachable.value = answer.problem.message;
    return;
  }
  postures.value = answer.result;
  unreachable.value = null;
  if (gizmoMoves.peek() === "live" && isDragged && mayMove.peek()) steer();
}

/** The user grabbed the gizmo, or released it: then the robot goes there. */
export async function dragTool(is: boolean): Promise<void> {
  isDragged = is;
  if (is) return;
  if (isDriving.peek()) await go();
}

/** Let the sliders' controller go to the posture. */
function steer(): boolean {
  const goal = posture.peek();
  if (goal === null) return false;
  if (!driveTo(goal.positions)) return false;
  noteCommand();
  return true;
}

function noteCommand(): void {
  isCommanded = true;
  movedAt = frames.latest?.time ?? 0;
}

/** Move the robot to the target, if the way is free; otherwise show a way around. */
export async function go(): Promise<void> {
  await letGo();
  await solving; // the last target may still wait for its postures
  const pose = target.peek();
  if (pose === null || unreachable.peek() !== null) return;
  const name = arm.peek()?.name ?? null;
  const there = { arm: name, pose: matrixOf(pose) };
  const goal = posture.peek();
  const inPosture =
    goal === null ? there : { arm: name, positions: { ...goal.positions } };
  const isStraight = way.peek() === "linear";
  await goThere({
    direct: isStraight ? there : inPosture,
    isStraight,
    target: chosenBranch.peek() === null ? there : inPosture,
    move: moveThere,
    moved: noteCommand,
  });
}

async function moveThere(): Promise<void> {
  const pose = target.peek();
  if (pose === null || unreachable.peek() !== null || !mayMove.peek()) return;
  if (way.peek() === "joint" && steer()) return;
  const to = { arm: arm.peek()?.name ?? null, pose: matrixOf(pose) };
  const share = speedScale.peek();
  const problem =
    way.peek() === "linear"
      ? await connection.request("move_linear", { ...to, speed: share * FASTEST })
      : await connection.request("move_to", {
          ...to,
          speed: share,
          branch: posture.peek()?.branch ?? null,
        });
  if (problem !== null) {
    report("error", problem.message);
    return;
  }
  followPlan();
  noteCommand();
}

const armName = computed(() => (view.value === null ? null : arm.value?.name));

// a target is of one arm, whether there is a picture or not
onChange(way, discard);

onChange(armName, () => {
  chosenBranch.value = null;
  forgetTarget();
});

/** Show the posture as a ghost, and forget a target once it is reached; the result ends that. */
export function watchTarget(): () => void {
  let isShown = false;
  const ends = [
    effect(() => {
      const shown = target.value === null ? null : posture.value;
      // without a target, others may show theirs
      if (shown !== null || isShown) plannedPose.value = shown?.positions ?? null;
      isShown = shown !== null;
    }),
    frames.listen(({ time, velocity }) => {
      if (!isCommanded || isDragged) return;
      if (time < movedAt || velocity.some((v) => Math.abs(v) > RESTING)) movedAt = time;
      if (time - movedAt > FORGET_AFTER) clear();
    }),
  ];
  return () => {
    for (const end of ends) end();
    forgetTarget();
  };
}
