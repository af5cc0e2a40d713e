/** Steps about the surroundings: a move until contact, and an object that is placed. */
import { t } from "../../i18n";
import { change } from "../../program/editor";
import type { Step } from "../../program/steps";
import { placeOfObject } from "../../program/teaching";
import { DEFAULTS, directionText, MM_PER_S, NEWTONS } from "../../program/words";
import { scene } from "../../store";
import { Button } from "../../ui/button";
import { Toggle } from "../../ui/toggle";
import { MILLIMETRES } from "../../units";
import { PoseFields } from "../pose-fields";
import { Choice, OptionalQuantity, Quantity } from "./fields";

type Until = Extract<Step, { kind: "until" }>;
type Place = Extract<Step, { kind: "place_object" }>;
type Direction = Until["direction"];

const AXES: readonly Direction[] = [
  [0, 0, -1],
  [0, 0, 1],
  [1, 0, 0],
  [-1, 0, 0],
  [0, 1, 0],
  [0, -1, 0],
];

export function UntilFields({ step }: { step: Until }) {
  const { direction, frame = "root", force = null } = step;
  const present = direction.join(" ");
  // also one that a file has and that is along no axis
  const known = AXES.map((one) => one.join(" "));
  const directions = [...new Set([...known, present])];
  return (
    <>
      <Choice
        label={t("program.direction")}
        value={present}
        options={directions.map((value) => ({
          value,
          label: directionText(value.split(" ").map(Number) as Direction, "root"),
        }))}
        data-testid="step-direction"
        onChange={(chosen) => {
          change({ ...step, direction: chosen.split(" ").map(Number) as Direction });
        }}
      />
      <Choice
        label={t("program.frame")}
        value={frame}
        options={(["root", "tool"] as const).map((value) => ({
          value,
          label: t(`program.frame.${value}`),
        }))}
        data-testid="step-frame"
        onChange={(chosen) => {
          change({ ...step, frame: chosen === "tool" ? "tool" : "root" });
        }}
      />
      <Quantity
        label={t("program.distance")}
        value={step.distance}
        unit={MILLIMETRES}
        min={0.001}
        max={10}
        data-testid="step-distance"
        onCommit={(distance) => {
          change({ ...step, distance });
        }}
      />
      <Quantity
        label={t("program.speed")}
        value={step.speed ?? DEFAULTS.until.speed}
        unit={MM_PER_S}
        min={0.001}
        max={1}
        data-testid="step-speed"
        onCommit={(speed) => {
          change({ ...step, speed });
        }}
      />
      <OptionalQuantity
        label={t("program.stopsAt")}
        value={force}
        initial={10}
        unit={NEWTONS}
        min={0.1}
        max={1000}
        data-testid="step-force"
        onCommit={(value) => {
          change({ ...step, force: value });
        }}
      />
      <Toggle
        label={t("program.mustTouch")}
        checked={step.must_touch ?? true}
        data-testid="step-must-touch"
        onChange={(isOn) => {
          change({ ...step, must_touch: isOn });
        }}
      />
    </>
  );
}

export function PlaceFields({ step }: { step: Place }) {
  const known = scene.value?.objects.map(({ name }) => name) ?? [];
  return (
    <>
      <Choice
        label={t("program.object")}
        value={step.name}
        options={[...new Set([...known, step.name])].map((value) => ({
          value,
          label: value,
        }))}
        data-testid="step-object"
        onChange={(chosen) => {
          change(placeOfObject(chosen));
        }}
      />
      <Button
        data-testid="step-teach"
        onClick={() => {
          change(placeOfObject(step.name));
        }}
      >
        {t("program.teachPlace")}
      </Button>
      <PoseFields
        value={{ position: step.xyz, rpy: step.rpy ?? [0, 0, 0] }}
        testId="step-pose"
        onChange={({ position, rpy }) => {
          change({ ...step, xyz: [...position], rpy: [...rpy] });
        }}
      />
    </>
  );
}
