/** Where the tool is to go: a pose from the gizmo or from numbers, and the postures that reach it. */
import { computed, effect, signal } from "@preact/signals";
import { connection } from "./connection";
import { driveTo, followPlan, isDriving, mayMove, speedScale } from "./driving";
import { frames } from "./frames";
import { letGo } from "./jog";
import type { Pose } from "./kinematics";
import { report } from "./notices";
import type { Branch, Collision } from "./protocol";
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

/** Collisions on the way to the target, which the page has shown: a second press goes anyway. */
export const collision = signal<Collision | null>(null);
/** The second click of a double click does not go anyway [ms]. */
const ANYWAY_AFTER_MS = 400;
let warnedAt = -Infinity;

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
  target.value = pose;
  collision.value = null;
  isCommanded = false;
  void solve();
}

/** Forget the target: fields and gizmo follow the tool again. */
export function forgetTarget(): void {
  target.value = null;
  collision.value = null;
  postures.value = [];
  unreachable.value = null;
  isCommanded = false;
}

/** Choose another posture, or the nearest with null. */
export function choosePosture(branch: string | null): void {
  chosenBranch.value = branch;
  collision.value = null;
}

function matrixOf({ p, R }: Pose): [Row, Row, Row, Row] {
  const row = (i: 0 | 1 | 2): Row => [R[i][0], R[i][1], R[i][2], p[i]];
  return [row(0), row(1), row(2), [0, 0, 0, 1]];
}
type Row = [number, number, number, number];

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
  isCommanded = true;
  movedAt = frames.latest?.time ?? 0;
  return true;
}

/**
 * Return whether nothing collides on the way to the target, or the user has been told what does.
 *
 * On a straight line only its end is checked: the posture changes along it in another way.
 */
async function isClear(): Promise<boolean> {
  const goal = posture.peek();
  if (goal === null) return true;
  if (collision.peek() !== null) return performance.now() - warnedAt > ANYWAY_AFTER_MS;
  const { positions } = goal;
  const answer = await connection.ask("find_collisions", { positions });
  if (answer.problem !== null) return true; // an engine that cannot tell
  const isStraight = way.peek() === "linear";
  const found = answer.result.find((pair) => !isStraight || pair.depth_at_end > 0);
  if (found === undefined || posture.peek() !== goal) return found === undefined;
  collision.value = found;
  warnedAt = performance.now();
  return false;
}

/** Move the robot to the target; where something would collide, at the second call. */
export async function go(): Promise<void> {
  await letGo();
  await solving; // the last target may still wait for its postures
  if (target.peek() === null || unreachable.peek() !== null) return;
  if (!(await isClear())) return;
  const pose = target.peek();
  if (pose === null || unreachable.peek() !== null || !mayMove.peek()) return;
  collision.value = null;
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
  isCommanded = true;
  movedAt = frames.latest?.time ?? 0;
}

const armName = computed(() => (view.value === null ? null : arm.value?.name));

// a target is of one arm, whether there is a picture or not
way.subscribe(() => {
  collision.value = null;
});

armName.subscribe(() => {
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
      if (time - movedAt > FORGET_AFTER) forgetTarget();
    }),
  ];
  return () => {
    for (const end of ends) end();
    forgetTarget();
  };
}
