/** The program that is being edited, kept in the browser between visits. */
import type { Program } from "../protocol";
import { recallText, remember } from "../ui/memory";
import type { Kind } from "./steps";

const DRAFT = "program";

/** What a step of each kind cannot be without. */
const REQUIRED: Record<Kind, readonly string[]> = {
  move_joint: [],
  move_linear: [],
  gripper: ["opening"],
  wait: [],
  until: ["direction", "distance"],
  place_object: ["name", "xyz"],
  set_output: ["output"],
  comment: ["text"],
  loop: [],
};

export function writeDraft(program: Program): void {
  remember(DRAFT, JSON.stringify(program));
}

/** Return the draft; null if there is none, or one of another version. */
export function readDraft(): Program | null {
  try {
    const draft = JSON.parse(recallText(DRAFT) ?? "") as Partial<Program> | null;
    const isOne = typeof draft?.name === "string" && areSteps(draft.steps);
    return isOne ? (draft as Program) : null;
  } catch {
    return null;
  }
}

function areSteps(value: unknown): boolean {
  return Array.isArray(value) && value.every(isStep);
}

function isStep(value: unknown): boolean {
  if (typeof value !== "object" || value === null) return false;
  const step = value as Record<string, unknown>;
  const kind = String(step.kind);
  if (!Object.hasOwn(REQUIRED, kind)) return false;
  const isWhole = REQUIRED[kind as Kind].every((name) => step[name] != null);
  return isWhole && (step.steps === undefined || areSteps(step.steps));
}
