/** The program that the user edits, with undo; a draft stays between visits. */
import { batch, computed, effect, signal } from "@preact/signals";
import type { Program } from "../protocol";
import { forgetCheck } from "./checking";
import { readDraft, writeDraft } from "./draft";
import {
  inserted,
  isLoop,
  moved,
  next,
  type Path,
  placeAfter,
  placeOf,
  removed,
  replaced,
  rowsOf,
  type Step,
  stepAt,
  type Way,
} from "./steps";

const MOST_UNDONE = 200;

/** What undo brings back. */
interface Edition {
  readonly program: Program;
  readonly selection: Path | null;
}

export const EMPTY: Program = { name: "program", steps: [] };
export const program = signal<Program>(readDraft() ?? EMPTY);
/** The step that is edited. */
export const selection = signal<Path | null>(null);
const past = signal<readonly Edition[]>([]);
const future = signal<readonly Edition[]>([]);
/** The program as it was saved or opened last. */
const saved = signal<Program | null>(null);

export const steps = computed<readonly Step[]>(() => program.value.steps ?? []);
export const rows = computed(() => rowsOf(steps.value));
export const selectedStep = computed(() =>
  selection.value === null ? undefined : stepAt(steps.value, selection.value),
);
export const mayUndo = computed(() => past.value.length > 0);
export const mayRedo = computed(() => future.value.length > 0);
export const isChanged = computed(
  () => program.value !== saved.value && steps.value.length > 0,
);

effect(() => {
  writeDraft(program.value);
});

/** Take an edited program; what was found of the one before is out of date. */
function edit(changed: Program, selected: Path | null = selection.peek()): void {
  batch(() => {
    past.value = [...past.peek(), now()].slice(-MOST_UNDONE);
    future.value = [];
    show({ program: changed, selection: selected });
  });
}

function now(): Edition {
  return { program: program.peek(), selection: selection.peek() };
}

function show(edition: Edition): void {
  program.value = edition.program;
  selection.value = edition.selection;
  forgetCheck();
}

export function undo(): void {
  const last = past.peek().at(-1);
  if (last === undefined) return;
  batch(() => {
    past.value = past.peek().slice(0, -1);
    future.value = [...future.peek(), now()];
    show(last);
  });
}

export function redo(): void {
  const last = future.peek().at(-1);
  if (last === undefined) return;
  batch(() => {
    future.value = future.peek().slice(0, -1);
    past.value = [...past.peek(), now()];
    show(last);
  });
}

/** Edit another program: a saved one, or one that was read from a file. */
export function open(other: Program, isSaved: boolean): void {
  edit(other, null);
  saved.value = isSaved ? other : null;
}

/** Note that a program was saved; what was edited since then is not. */
export function noteSaved(one: Program): void {
  saved.value = one;
}

export function rename(name: string): void {
  if (name !== program.peek().name) edit({ ...program.peek(), name });
}

function withSteps(changed: Step[]): Program {
  return { ...program.peek(), steps: changed };
}

/** Add a step: in the selected loop, or after the selected step. */
export function add(step: Step): void {
  const path = placeAfter(steps.peek(), selection.peek());
  edit(withSteps(inserted(steps.peek(), path, step)), path);
}

/** Change the selected step. */
export function change(step: Step): void {
  const path = selection.peek();
  if (path !== null) edit(withSteps(replaced(steps.peek(), path, step)));
}

export function duplicate(): void {
  const [path, step] = [selection.peek(), selectedStep.peek()];
  if (path === null || step === undefined) return;
  edit(withSteps(inserted(steps.peek(), next(path), step)), next(path));
}

/** Delete the selected step; the one that follows is selected, or the last. */
export function remove(): void {
  const path = selection.peek();
  if (path === null) return;
  const left = removed(steps.peek(), path);
  const above = path.length > 1 ? path.slice(0, -1) : null;
  const near = [path, next(path, -1), above];
  const selected = near.find((one) => one !== null && stepAt(left, one));
  edit(withSteps(left), selected ?? null);
}

/** Put a loop around the selected step. */
export function wrap(): void {
  const [path, step] = [selection.peek(), selectedStep.peek()];
  if (path === null || step === undefined) return;
  const loop: Step = { kind: "loop", times: 2, steps: [step] };
  edit(withSteps(replaced(steps.peek(), path, loop)), path);
}

/** Move the selected step; return whether there is such a place. */
export function moveSelected(way: Way): boolean {
  const path = selection.peek();
  const to = path && placeOf(steps.peek(), path, way);
  return path !== null && to !== null && move(path, to);
}

/** Move a step to where `to` is now; return whether it can be there. */
export function move(from: Path, to: Path): boolean {
  const found = moved(steps.peek(), from, to);
  if (found === null) return false;
  edit(withSteps(found.steps), found.path);
  return true;
}

/** Select the step that is `by` rows below, or the first or last. */
export function selectBy(by: number): void {
  const all = rows.peek();
  const at = all.findIndex(({ path }) => path.join() === selection.peek()?.join());
  const to = Math.min(all.length - 1, Math.max(0, at < 0 ? 0 : at + by));
  selection.value = all[to]?.path ?? null;
}

/** Return whether there is a loop that a step can be moved into. */
export function mayNest(path: Path): boolean {
  return isLoop(stepAt(steps.value, next(path, -1)));
}
