/**
 * The steps of a program as a tree.  A step is named as the server names it: by its
 * number from 1 on, after those of the loops around it.
 */
import type { LoopStep, Program } from "../protocol";

export type Step = NonNullable<Program["steps"]>[number];
export type Kind = Step["kind"];
export type Path = readonly number[];
export type MoveStep = Extract<Step, { kind: "move_joint" | "move_linear" }>;

/** A step, where it is, and how deep in loops. */
export interface Row {
  readonly path: Path;
  readonly step: Step;
}

/** As in `tool0.programs.model.MOST_NESTED`. */
const MOST_NESTED = 10;

export function isLoop(step: Step | undefined): step is LoopStep {
  return step?.kind === "loop";
}

export function isMove(step: Step | undefined): step is MoveStep {
  return step?.kind === "move_joint" || step?.kind === "move_linear";
}

/** Return the path as people write it: `3.2`. */
export function pathText(path: Path): string {
  return path.join(".");
}

export function samePath(a: Path, b: Path): boolean {
  return a.length === b.length && a.every((number, i) => number === b[i]);
}

/** Return whether `path` is `whole`, or in it. */
function isWithin(path: Path, whole: Path): boolean {
  return whole.every((number, i) => number === path[i]);
}

/** Return every step with its path, a loop before its steps. */
export function rowsOf(steps: readonly Step[], parents: Path = []): Row[] {
  return steps.flatMap((step, i) => {
    const path = [...parents, i + 1];
    const inner = isLoop(step) ? rowsOf(step.steps ?? [], path) : [];
    return [{ path, step }, ...inner];
  });
}

export function stepAt(steps: readonly Step[], path: Path): Step | undefined {
  const [first, ...rest] = path;
  const step = first === undefined ? undefined : steps[first - 1];
  if (rest.length === 0) return step;
  return isLoop(step) ? stepAt(step.steps ?? [], rest) : undefined;
}

/** Return the steps with the list that contains `path` changed; `at` is its index there. */
function changed(
  steps: readonly Step[],
  path: Path,
  change: (list: readonly Step[], at: number) => readonly Step[],
): Step[] {
  const [first = 1, ...rest] = path;
  if (rest.length === 0) return [...change(steps, first - 1)];
  return steps.map((step, i) =>
    i === first - 1 && isLoop(step)
      ? { ...step, steps: changed(step.steps ?? [], rest, change) }
      : step,
  );
}

/** Return the steps with `added` where `path` is; what was there follows. */
export function inserted(steps: readonly Step[], path: Path, added: Step): Step[] {
  return changed(steps, path, (list, at) => [
    ...list.slice(0, at),
    added,
    ...list.slice(at),
  ]);
}

export function removed(steps: readonly Step[], path: Path): Step[] {
  return changed(steps, path, (list, at) => list.filter((_, i) => i !== at));
}

export function replaced(steps: readonly Step[], path: Path, step: Step): Step[] {
  return changed(steps, path, (list, at) =>
    list.map((old, i) => (i === at ? step : old)),
  );
}

/** Return where the next step goes: into a selected loop, or after what is selected. */
export function placeAfter(steps: readonly Step[], path: Path | null): Path {
  if (path === null) return [steps.length + 1];
  const step = stepAt(steps, path);
  if (isLoop(step)) return [...path, (step.steps?.length ?? 0) + 1];
  return next(path);
}

/** Return the path of the step that follows in the same list. */
export function next(path: Path, by = 1): Path {
  return [...path.slice(0, -1), (path.at(-1) ?? 0) + by];
}

interface Moved {
  readonly steps: Step[];
  readonly path: Path;
}

/** Return the steps with that of `from` at `to`, and its path then; null if it cannot be there. */
export function moved(steps: readonly Step[], from: Path, to: Path): Moved | null {
  const step = stepAt(steps, from);
  if (step === undefined || isWithin(to, from)) return null;
  if (to.length - 1 + depthOf(step) > MOST_NESTED) return null;
  const without = removed(steps, from);
  const path = afterRemoval(to, from);
  return { steps: inserted(without, path, step), path };
}

/** Return how many loops are within each other in a step. */
function depthOf(step: Step): number {
  return isLoop(step) ? 1 + Math.max(0, ...(step.steps ?? []).map(depthOf)) : 0;
}

/** Return what becomes of a path when the step at `gone` goes. */
function afterRemoval(path: Path, gone: Path): Path {
  const at = gone.length - 1;
  const isSameList = isWithin(path, gone.slice(0, -1)) && path.length > at;
  if (!isSameList || (path[at] ?? 0) <= (gone[at] ?? 0)) return path;
  return path.map((number, i) => (i === at ? number - 1 : number));
}

export type Way = "up" | "down" | "in" | "out";

/**
 * Return where a step goes: up and down among its neighbours, into the loop above it, or
 * out behind the loop that it is in; null if there is no such place.
 */
export function placeOf(steps: readonly Step[], path: Path, way: Way): Path | null {
  const at = path.at(-1) ?? 1;
  const before = stepAt(steps, next(path, -1));
  switch (way) {
    case "up":
      return at > 1 ? next(path, -1) : null;
    case "down":
      return stepAt(steps, next(path)) ? next(path, 2) : null;
    case "in":
      return isLoop(before)
        ? [...next(path, -1), (before.steps?.length ?? 0) + 1]
        : null;
    case "out":
      return path.length > 1 ? next(path.slice(0, -1)) : null;
  }
}
