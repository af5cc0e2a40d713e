/** What the user has selected in the scene: a link of the robot, or an object. */
import { computed, signal } from "@preact/signals";
import { model } from "./model";
import type { ViewObject } from "./protocol";
import { shownScene } from "./store";

export interface Selection {
  readonly kind: "link" | "object";
  readonly name: string;
}

const chosen = signal<Selection | null>(null);

/** Null also when what was selected exists no longer. */
export const selection = computed<Selection | null>(() => {
  const now = chosen.value;
  if (now === null) return null;
  const exists =
    now.kind === "link"
      ? model.value?.links.has(now.name) === true
      : objectNamed(now.name) !== undefined;
  return exists ? now : null;
});

/** The selected object. */
export const selectedObject = computed<ViewObject | undefined>(() =>
  selection.value?.kind === "object" ? objectNamed(selection.value.name) : undefined,
);

export function select(what: Selection | null): void {
  chosen.value = what;
}

function objectNamed(name: string): ViewObject | undefined {
  return shownScene.value?.objects.find((object) => object.name === name);
}
