/** Keys that edit what is selected in the scene, while the picture has the focus. */
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

/** Do what a key, as `keyName` has it, does; return whether it does something. */
export function editByKey(key: string): boolean {
  if (key === "a") {
    togglePlacing();
    return true;
  }
  const object = selectedObject.peek();
  if (!object) return false;
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
