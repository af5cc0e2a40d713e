/** A new object that the user is about to place in the scene with the pointer. */
import { signal } from "@preact/signals";
import type { AddObject } from "./protocol";
import { addObject, freeName } from "./scene-edits";
import { report } from "./notices";
import { select } from "./selection";
import type { Vector } from "./urdf";

export type SimpleShape = Exclude<
  AddObject["shape"],
  { kind: "mesh" } | { kind: "compound" }
>;

/** A new object without a place. */
export interface NewObject {
  readonly name: string;
  readonly shape: SimpleShape;
  readonly mass: number | null;
  readonly friction: number;
}

/** What the pointer places; null while it places nothing. */
export const placing = signal<NewObject | null>(null);

/** Placed last; to begin with, a cube that every gripper can hold. */
let last: NewObject = {
  name: "box",
  shape: { kind: "box", size: [0.04, 0.04, 0.04] },
  mass: 0.1,
  friction: 1,
};

/** Start to place an object, by default another one like the last; or stop that. */
export function togglePlacing(object: NewObject = last): void {
  placing.value = placing.peek() ? null : { ...object, name: freeName(object.name) };
}

/** Add the object at `xyz` [m], and select it; `again` goes on with another one. */
export async function place(xyz: Vector, again: boolean): Promise<void> {
  const object = placing.peek();
  if (!object) return;
  last = object;
  placing.value = null;
  const problem = await addObject({ ...object, xyz: [...xyz] });
  if (problem) {
    report("error", problem.message);
    return;
  }
  select({ kind: "object", name: object.name });
  const stem = object.name.replace(/ \d+$/, "");
  if (again) placing.value = { ...object, name: nextName(stem, object.name) };
}

/** Return a free name, also if the scene does not show the object `added` yet. */
function nextName(stem: string, added: string): string {
  const free = freeName(stem);
  if (free !== added) return free;
  const number = Number(/ (\d+)$/.exec(added)?.[1] ?? 1);
  return `${stem} ${String(number + 1)}`;
}
