/** Waypoints: moves to where the arm is. */
import { add as addStep, selection } from "./editor";
import { pathText } from "./steps";
import { newStep } from "./teaching";

/** Add a move after the selected step; return its number. */
export function add(): string {
  addStep(newStep("move_joint"));
  return pathText(selection.peek() ?? []);
}
