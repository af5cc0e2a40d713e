/** The fields of the selected step. */
import { t } from "../../i18n";
import { change, selectedStep, selection } from "../../program/editor";
import { pathText, type Step } from "../../program/steps";
import { titleOf } from "../../program/words";
import { GripperFields, LoopFields, OutputFields, WaitFields } from "./action-fields";
import { MoveFields } from "./move-fields";
import { PlaceFields, UntilFields } from "./place-fields";

export function StepFields() {
  const [path, step] = [selection.value, selectedStep.value];
  if (path === null || step === undefined) return null;
  return (
    <section
      class="group"
      id="step-fields"
      aria-labelledby="step-title"
      data-testid="program-fields"
    >
      <header>
        <h2 id="step-title">
          {t("program.step", { step: pathText(path) })} · {titleOf(step)}
        </h2>
      </header>
      <Fields key={pathText(path)} step={step} />
    </section>
  );
}

function Fields({ step }: { step: Step }) {
  switch (step.kind) {
    case "move_joint":
    case "move_linear":
      return <MoveFields step={step} />;
    case "gripper":
      return <GripperFields step={step} />;
    case "wait":
      return <WaitFields step={step} />;
    case "until":
      return <UntilFields step={step} />;
    case "place_object":
      return <PlaceFields step={step} />;
    case "set_output":
      return <OutputFields step={step} />;
    case "loop":
      return <LoopFields step={step} />;
    case "comment":
      return (
        <span class="field grow">
          <input
            type="text"
            maxLength={1000}
            value={step.text}
            aria-label={t("program.kind.comment")}
            data-testid="step-text"
            onChange={(event) => {
              change({ ...step, text: event.currentTarget.value });
            }}
          />
        </span>
      );
  }
}
