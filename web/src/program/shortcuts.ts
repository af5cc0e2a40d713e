/** The program's shortcuts that work anywhere; the editor is loaded with the first use. */
import { shownBox } from "../control-box";
import { t } from "../i18n";
import { report } from "../notices";
import { register } from "../shortcuts";
import { offers } from "../store";

/** Add a move to where the arm is now. */
export function addWaypoint(): void {
  void import("./waypoint").then(({ add }) => {
    report("info", t("program.waypoint", { step: add() }));
  });
}

register(
  {
    keys: ["w"],
    text: "shortcuts.waypoint",
    group: "program",
    run: addWaypoint,
    when: () => shownBox.peek() !== null && offers("run_program"),
  },
  { keys: ["↑", "↓"], text: "shortcuts.steps", group: "program" },
  {
    keys: ["Alt+↑", "Alt+↓", "Alt+→", "Alt+←"],
    text: "shortcuts.moveStep",
    group: "program",
  },
  { keys: ["Enter"], text: "shortcuts.editStep", group: "program" },
  { keys: ["Delete"], text: "shortcuts.deleteStep", group: "program" },
  { keys: ["Ctrl+d"], text: "shortcuts.duplicateStep", group: "program" },
  { keys: ["Ctrl+z", "Ctrl+Shift+z"], text: "shortcuts.undoStep", group: "program" },
);
