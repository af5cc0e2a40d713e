/** Keys that edit what is selected in the scene, while the picture has the focus. */
import type { Method } from "../messages";
import { togglePlacing } from "../placing";
import {
  canRedo,
  canUndo,
  duplicateObject,
  redo,
  removeObjects,
  undo,
} from "../scene-edits";
import { select, selectedObject } from "../selection";
import { register } from "../shortcuts";
import { offers } from "../store";
import { toggleHandles } from "./card";

register(
  { keys: ["Click"], text: "shortcuts.select", group: "scene" },
  { keys: ["g", "r"], text: "shortcuts.edit", group: "scene" },
  { keys: ["Ctrl+d"], text: "shortcuts.duplicate", group: "scene" },
  { keys: ["Delete"], text: "shortcuts.remove", group: "scene" },
  { keys: ["a"], text: "shortcuts.add", group: "scene" },
  {
    keys: ["Ctrl+z"],
    text: "shortcuts.undo",
    group: "scene",
    run: () => void undo(),
    when: () => canUndo.value,
  },
  {
    keys: ["Ctrl+Shift+z", "Ctrl+y"],
    text: "shortcuts.redo",
    group: "scene",
    run: () => void redo(),
    when: () => canRedo.value,
  },
);

/** Key for what is selected → the method that it needs. */
const METHODS: ReadonlyMap<string, Method> = new Map([
  ["g", "place_object"],
  ["r", "place_object"],
  ["Ctrl+d", "add_object"],
  ["Delete", "remove_object"],
  ["Backspace", "remove_object"],
]);

/** Do what a key, as `keyName` has it, does; return whether it does something. */
export function editByKey(key: string): boolean {
  if (key === "a") {
    if (!offers("add_object")) return false;
    togglePlacing();
    return true;
  }
  const object = selectedObject.peek();
  if (!object) return false;
  const method = METHODS.get(key);
  if (method === undefined || !offers(method)) return false;
  switch (key) {
    case "g":
      toggleHandles(object.name, "move");
      return true;
    case "r":
      toggleHandles(object.name, "rotate");
      return true;
    case "Ctrl+d":
      void duplicateObject(object);
      return true;
    case "Delete":
    case "Backspace":
      select(null);
      void removeObjects([object]);
      return true;
    default:
      return false;
  }
}
