/** Running the program, and how far it is. */
import { computed, signal } from "@preact/signals";
import { connection } from "../connection";
import { endGuiding } from "../guiding";
import { letGo } from "../jog";
import type { ErrorInfo, Program, ProgramRun } from "../protocol";
import { robots, selected } from "../robots";
import { status } from "../store";
import { forgetStart, isAtStart } from "./approach";
import { check, checkProgram } from "./checking";
import { program } from "./editor";
import type { Path } from "./steps";

/** Why the last request was refused. */
export const refusal = signal<string | null>(null);

/** The last program of the shown arm. */
export const run = computed<ProgramRun | null>(() => {
  const all = status.value?.programs ?? [];
  const arm = selected.value?.name;
  return all.find((one) => arm === undefined || one.arm === arm) ?? null;
});
export const isRunning = computed(
  () => run.value?.state === "running" || run.value?.state === "paused",
);

/** What `start` sent last, as it was edited then. */
const started = signal<Program | null>(null);

/** The path of the step that is executed now, if it is one of the shown program. */
export const runningStep = computed<Path | null>(() => {
  const now = run.value;
  if (!isRunning.value || now?.program !== program.value.name) return null;
  const isShown = started.value === null || started.value === program.value;
  return isShown ? (now.step ?? null) : null;
});

/** Return the program as requests have it: of several arms, it names its own. */
export function requested(): Program {
  const now = program.peek();
  if ((now.arm ?? null) !== null || robots.peek().length === 0) return now;
  return { ...now, arm: selected.peek()?.name ?? null };
}

/** Run the program, if the arm is where it begins; otherwise the user is asked. */
export async function start(): Promise<void> {
  const starting = program.peek();
  refusal.value = null;
  const isFine = await checkProgram(requested());
  const found = check.peek();
  if (!isFine || found === null) return; // the findings say why, or it was edited
  if (isAtStart(found.motion, starting)) await startHere();
}

/** Run the program from where the arm is, or let it wait before its first step. */
export async function startHere(paused = false): Promise<void> {
  forgetStart();
  await endGuiding();
  await letGo();
  const starting = program.peek();
  const problem = await connection.request("run_program", {
    program: requested(),
    paused,
  });
  refusal.value = null;
  if (problem === null) {
    started.value = starting;
    return;
  }
  // which steps are wrong, if that is why
  const isFine = await checkProgram(requested());
  if (isFine || check.peek() === null) refusal.value = problem.message;
}

type Control = "pause_run" | "resume_run" | "step_run" | "stop_run";

export async function control(method: Control): Promise<void> {
  const arm = run.peek()?.arm ?? null;
  const problem: ErrorInfo | null = await connection.request(method, { arm });
  refusal.value = problem?.message ?? null;
}
