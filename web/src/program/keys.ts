/** Keys of the panel: undo, and those that concern the selected step. */
import { isTyping, keyName } from "../shortcuts";
import { duplicate, moveSelected, redo, remove, selectBy, undo } from "./editor";
import type { Way } from "./steps";

/** While the focus is in the panel. */
const ANYWHERE: Partial<Record<string, () => void>> = {
  "Ctrl+z": undo,
  "Ctrl+Shift+z": redo,
  "Ctrl+y": redo,
};

export function watchKeys(event: KeyboardEvent): void {
  const act = isTyping(event) ? undefined : ANYWHERE[keyName(event)];
  if (act === undefined) return;
  event.preventDefault();
  act();
}

const WAYS: Partial<Record<string, Way>> = {
  ArrowUp: "up",
  ArrowDown: "down",
  ArrowRight: "in",
  ArrowLeft: "out",
};

/** While the focus is in the list of steps. */
const IN_LIST: Partial<Record<string, () => void>> = {
  ArrowUp: () => {
    selectBy(-1);
  },
  ArrowDown: () => {
    selectBy(1);
  },
  Home: () => {
    selectBy(-Infinity);
  },
  End: () => {
    selectBy(Infinity);
  },
  Delete: remove,
  Backspace: remove,
  "Ctrl+d": duplicate,
};

/** Return whether the key did something. */
export function onListKey(event: KeyboardEvent): boolean {
  const way = event.altKey ? WAYS[event.key] : undefined;
  if (way) moveSelected(way);
  const act = event.altKey ? undefined : IN_LIST[keyName(event)];
  act?.();
  if (way === undefined && act === undefined) return false;
  event.preventDefault();
  return true;
}
