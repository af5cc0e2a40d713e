/**
 * Going to a target: at once if the direct way is free.  Otherwise the server plans a way
 * around, which the scene shows before the user lets the robot move.
 */
import { computed, effect, signal } from "@preact/signals";
import { onChange } from "../changes";
import { connection } from "../connection";
import { adopt, mayMove, speedScale } from "../driving";
import { frames } from "../frames";
import { t } from "../i18n";
import { letGo } from "../jog";
import type { Frame } from "../messages";
import { model } from "../model";
import { report } from "../notices";
import type { Plan, PlanTarget } from "../protocol";
import { jointIndex } from "../store";
import { arm } from "../tool";
import type { Vector } from "../urdf";
import { obstacleTo } from "./check";
import { durationOf, endOf, pathOf, postureAt, startOf } from "./plan";

/** Where one arm is to go, and how it goes there directly. */
export interface Trip {
  /** The end of the direct way. */
  readonly direct: PlanTarget;
  /** Whether the tool moves on a straight line; otherwise the joints do. */
  readonly isStraight: boolean;
  /** Where a way around may end. */
  readonly target: PlanTarget;
  /** Move directly. */
  readonly move: () => Promise<void>;
  /** Called when the robot moves on the way around. */
  readonly moved?: () => void;
}

interface Blocked {
  readonly trip: Trip;
  /** Which bodies block the direct way. */
  readonly obstacle: string;
}

/** What there is instead of the direct way. */
export type WayAround =
  | (Blocked & { readonly state: "searching" })
  | (Blocked & {
      readonly state: "found";
      readonly plan: Plan;
      /** Of the tool, in the root [m]. */
      readonly path: readonly Vector[];
      /** Where the objects were. */
      readonly objects: Frame["objects"];
    })
  | (Blocked & { readonly state: "none"; readonly problem: string });

/** Motions that nobody planned may press on something so deep: as in `robot.arm.move` [m]. */
const PRESSING = 0.002;
/** An effort controller without an integral holds an arm some 10 mrad from its setpoint [rad]. */
const MOVED = 0.025;
/** An object that the server, too, says has moved [m]. */
const OBJECT_MOVED = 0.002;

/** Null while the direct way is free, or nothing was asked for. */
export const wayAround = signal<WayAround | null>(null);
/** Where the slider is on the plan [s]. */
export const shownTime = signal(0);

/** Where the ghost is: joint → position [rad]; null without a plan. */
export const shownPosture = computed(() => {
  const now = wayAround.value;
  return now?.state === "found" ? postureAt(now.plan, shownTime.value) : null;
});
/** The way of the tool in the root [m]; null without a plan. */
export const shownPath = computed(() =>
  wayAround.value?.state === "found" ? wayAround.value.path : null,
);

/** Grows when another target is gone to, or none. */
let generation = 0;

/** Go to a target, or show the way around what blocks the direct one. */
export async function goThere(trip: Trip): Promise<void> {
  discard();
  const ours = generation;
  const { direct, isStraight } = trip;
  const obstacle = await obstacleTo(direct, { isStraight, clearance: -PRESSING });
  if (ours !== generation) return;
  if (obstacle === null) {
    await trip.move();
    return;
  }
  wayAround.value = { trip, obstacle, state: "searching" };
  const answer = await connection.ask("plan_motion", {
    targets: [trip.target],
    speed: speedScale.peek(),
  });
  if (ours !== generation) return;
  if (answer.problem !== null) {
    const problem = answer.problem.message;
    wayAround.value = { trip, obstacle, state: "none", problem };
    return;
  }
  const plan = answer.result;
  const objects = frames.latest?.objects ?? [];
  wayAround.value = { trip, obstacle, state: "found", plan, path: way(plan), objects };
  shownTime.value = durationOf(plan);
}

/** Return the way of the tool. */
function way(plan: Plan): readonly Vector[] {
  const [urdf, tip] = [model.peek(), arm.peek()?.tip];
  if (urdf === null || tip === undefined) return [];
  return pathOf(plan, urdf, tip, measured);
}

function measured(joint: string): number | undefined {
  return frames.latest?.position[jointIndex.peek().get(joint) ?? -1];
}

/** Forget the plan, or end its search; nothing moves. */
export function discard(): void {
  generation += 1;
  const wasSearching = wayAround.peek()?.state === "searching";
  wayAround.value = null;
  if (wasSearching) void connection.request("cancel_planning");
}

/** Move on the way that is shown. */
export async function moveAround(): Promise<void> {
  const now = wayAround.peek();
  if (now?.state !== "found" || !mayMove.peek()) return;
  const { plan, trip } = now;
  discard();
  await letGo();
  const problem = await connection.request("execute_plan", { number: plan.number });
  if (problem !== null) {
    report("error", problem.message);
    return;
  }
  adopt(endOf(plan));
  trip.moved?.();
}

/** Move directly, though something is in the way. */
export async function moveAnyway(): Promise<void> {
  const now = wayAround.peek();
  if (now?.state !== "none" || !mayMove.peek()) return;
  discard();
  await now.trip.move();
}

/** Return why a plan can no longer be executed, or null. */
function whyOutdated(plan: Plan, objects: Frame["objects"], now: Frame): string | null {
  const hasMoved = Object.entries(startOf(plan)).some(([joint, start]) => {
    const index = jointIndex.peek().get(joint) ?? -1;
    const q = now.desired[index] ?? now.position[index] ?? start;
    return Math.abs(q - start) > MOVED;
  });
  if (hasMoved) return t("plan.armMoved");
  const isAsBefore =
    objects.length === now.objects.length &&
    objects.every(([[x, y, z]], k) => {
      const [a, b, c] = now.objects[k]?.[0] ?? [Infinity, 0, 0];
      return Math.hypot(a - x, b - y, c - z) <= OBJECT_MOVED;
    });
  return isAsBefore ? null : t("plan.sceneChanged");
}

frames.listen((frame) => {
  const now = wayAround.peek();
  if (now?.state !== "found") return;
  const why = whyOutdated(now.plan, now.objects, frame);
  if (why === null) return;
  discard();
  report("warning", why);
});

// a plan is for one arm, and for a page that may move it
effect(() => {
  if (!mayMove.value) discard();
});
onChange(
  computed(() => arm.value?.name),
  discard,
);
