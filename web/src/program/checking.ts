/** What the server says of a program before it runs, and the preview of its motion. */
import { computed, signal } from "@preact/signals";
import { connection } from "../connection";
import type { PlannedMotion, Program, ProgramCheck, ProgramProblem } from "../protocol";
import { plannedPath } from "../scene/path";
import { plannedPose } from "../scene/planned-pose";
import { type Path, pathText, samePath } from "./steps";

/** What the last check found; null before one, and after a change. */
export const check = signal<ProgramCheck | null>(null);
/** Why it could not be checked. */
export const checkFailure = signal<string | null>(null);
export const isChecking = signal(false);

/** Step → the first problem, or else warning, of it. */
export const remarks = computed(() => {
  const found = new Map<string, ProgramProblem & { isError: boolean }>();
  const add = (all: readonly ProgramProblem[], isError: boolean) => {
    for (const one of all) {
      const path = pathText(one.step);
      if (!found.has(path)) found.set(path, { ...one, isError });
    }
  };
  add(check.value?.problems ?? [], true);
  add(check.value?.warnings ?? [], false);
  return found;
});

/** Grows when a check is begun, or what it is of changes. */
let generation = 0;
/** Grows when nothing more is to be seen of a plan. */
let hidings = 0;

export function forgetCheck(): void {
  generation += 1;
  isChecking.value = false;
  check.value = null;
  checkFailure.value = null;
  hidePreview();
}

/** Plan the program on the server; show its path.  Return whether it can be executed. */
export async function checkProgram(program: Program): Promise<boolean> {
  isChecking.value = true;
  const ours = ++generation;
  const before = hidings;
  const answer = await connection.ask("check_program", { program });
  if (ours !== generation) return false; // the program has changed
  isChecking.value = false;
  if (answer.problem) {
    check.value = null;
    checkFailure.value = answer.problem.message;
    return false;
  }
  check.value = answer.result;
  checkFailure.value = null;
  if (before === hidings) plannedPath.value = answer.result.motion.points;
  return answer.result.problems.length === 0;
}

// ---- the preview --------------------------------------------------------------------

export function hidePreview(): void {
  hidings += 1;
  plannedPath.value = null;
  plannedPose.value = null;
}

/** Let the ghost be where the plan is at `time` [s]. */
export function showAt(motion: PlannedMotion, time: number): void {
  plannedPose.value = poseAt(motion, time);
}

/** Let the ghost be where a step of the plan ends; nowhere if the step moves nothing. */
export function showStep(path: Path | null): void {
  const motion = check.peek()?.motion;
  if (motion === undefined) return;
  const at = motion.steps
    .map((step) => path !== null && samePath(step, path))
    .lastIndexOf(true);
  plannedPose.value = at < 0 ? null : poseAt(motion, motion.times[at] ?? 0);
}

/** Return the positions of the joints at a time of the plan, linear in between. */
export function poseAt(motion: PlannedMotion, time: number): Record<string, number> {
  const { times, positions, joint_names: names } = motion;
  const after = times.findIndex((one) => one >= time);
  const last = after < 0 ? times.length - 1 : after;
  const first = Math.max(0, last - 1);
  const [start = 0, end = 0] = [times[first], times[last]];
  const part =
    end > start ? Math.min(1, Math.max(0, (time - start) / (end - start))) : 1;
  return Object.fromEntries(
    names.map((name, i) => {
      const [a = 0, b = 0] = [positions[first]?.[i], positions[last]?.[i]];
      return [name, a + part * (b - a)];
    }),
  );
}
