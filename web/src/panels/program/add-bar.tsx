/** Buttons that add steps: moves to where the arm is, and all others. */
import { t } from "../../i18n";
import { add } from "../../program/editor";
import type { Kind } from "../../program/steps";
import { newStep } from "../../program/teaching";
import { Button } from "../../ui/button";
import { KIND_ICONS } from "./icons";

const KINDS: readonly Kind[] = [
  "move_joint",
  "move_linear",
  "gripper",
  "wait",
  "until",
  "place_object",
  "set_output",
  "loop",
  "comment",
];

export function AddBar() {
  return (
    <div class="add-steps" role="group" aria-label={t("program.add")}>
      {KINDS.map((kind) => {
        const Icon = KIND_ICONS[kind];
        return (
          <Button
            key={kind}
            title={t(`program.hint.${kind}`)}
            data-testid={`program-add-${kind}`}
            onClick={() => {
              add(newStep(kind));
            }}
          >
            <Icon />
            {t(`program.kind.${kind}`)}
          </Button>
        );
      })}
    </div>
  );
}
