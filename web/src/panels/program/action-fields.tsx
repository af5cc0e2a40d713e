/** Steps that do not move the arm: gripper, wait, output and loop. */
import { t } from "../../i18n";
import { change } from "../../program/editor";
import type { Step } from "../../program/steps";
import { programRobot } from "../../program/teaching";
import { inputText, MM_PER_S, NEWTONS, pinText, SECONDS } from "../../program/words";
import type { GripperInfo } from "../../protocol";
import { view } from "../../store";
import { Toggle } from "../../ui/toggle";
import { MILLIMETRES } from "../../units";
import { Choice, Level, OptionalQuantity, Pin, Quantity } from "./fields";

type Of<K extends Step["kind"]> = Extract<Step, { kind: K }>;

/** The gripper of the program's arm. */
function gripper(): GripperInfo | undefined {
  const all = view.value?.robot.grippers ?? [];
  const name = programRobot()?.gripper;
  return all.find((one) => one.name === name) ?? all[0];
}

export function GripperFields({ step }: { step: Of<"gripper"> }) {
  const info = gripper();
  const widest = info?.max_opening ?? 0.2;
  const { opening, speed = null, force = null } = step;
  return (
    <>
      <Choice
        label={t("program.opening")}
        value={typeof opening === "string" ? opening : "width"}
        options={(["open", "closed", "width"] as const).map((value) => ({
          value,
          label: t(value === "open" ? "program.opened" : `program.${value}`),
        }))}
        data-testid="step-opening"
        onChange={(chosen) => {
          const isWord = chosen === "open" || chosen === "closed";
          change({ ...step, opening: isWord ? chosen : widest / 2 });
        }}
      />
      {typeof opening === "number" && (
        <Quantity
          label={t("program.width")}
          value={opening}
          unit={MILLIMETRES}
          min={0}
          max={widest}
          data-testid="step-width"
          onCommit={(value) => {
            change({ ...step, opening: value });
          }}
        />
      )}
      <OptionalQuantity
        label={t("program.speed")}
        value={speed}
        initial={info?.max_speed ?? 0.1}
        unit={MM_PER_S}
        min={info?.min_speed ?? 0.001}
        max={info?.max_speed ?? 1}
        data-testid="step-speed"
        onCommit={(value) => {
          change({ ...step, speed: value });
        }}
      />
      <OptionalQuantity
        label={t("program.force")}
        value={force}
        initial={info?.max_force ?? 50}
        unit={NEWTONS}
        min={info?.min_force ?? 1}
        max={info?.max_force ?? 1000}
        data-testid="step-force"
        onCommit={(value) => {
          change({ ...step, force: value });
        }}
      />
      <Toggle
        label={t("program.mustHold")}
        checked={step.must_hold ?? false}
        data-testid="step-must-hold"
        onChange={(isOn) => {
          change({ ...step, must_hold: isOn });
        }}
      />
    </>
  );
}

export function WaitFields({ step }: { step: Of<"wait"> }) {
  const { duration = null, input = null, level = true } = step;
  const commit = (value: number | null) => {
    change({ ...step, duration: value });
  };
  const time = { unit: SECONDS, min: 0, max: 1e6, "data-testid": "step-duration" };
  return (
    <>
      <Choice
        label={t("program.waitFor")}
        value={input === null ? "time" : "input"}
        options={(["time", "input"] as const).map((value) => ({
          value,
          label: t(`program.waitFor.${value}`),
        }))}
        data-testid="step-wait"
        onChange={(chosen) => {
          change(
            chosen === "time"
              ? { kind: "wait", duration: duration ?? 1 }
              : { kind: "wait", input: 0, level: true },
          );
        }}
      />
      {input === null ? (
        <Quantity
          label={t("program.duration")}
          value={duration ?? 0}
          onCommit={commit}
          {...time}
        />
      ) : (
        <>
          <Pin
            label={t("program.input")}
            pin={input}
            nameOf={inputText}
            onChange={(pin) => {
              change({ ...step, input: pin });
            }}
          />
          <Level
            level={level}
            onChange={(chosen) => {
              change({ ...step, level: chosen });
            }}
          />
          <OptionalQuantity
            label={t("program.atMost")}
            value={duration}
            initial={10}
            onCommit={commit}
            {...time}
          />
        </>
      )}
    </>
  );
}

export function OutputFields({ step }: { step: Of<"set_output"> }) {
  return (
    <>
      <Pin
        label={t("program.output")}
        pin={step.output}
        nameOf={pinText}
        onChange={(pin) => {
          change({ ...step, output: pin });
        }}
      />
      <Level
        level={step.level ?? true}
        onChange={(level) => {
          change({ ...step, level });
        }}
      />
    </>
  );
}

const LOOPS = {
  times: { times: 2, while_input: null },
  forever: { times: null, while_input: null },
  input: { times: null, while_input: 0, level: true },
} as const;

export function LoopFields({ step }: { step: Of<"loop"> }) {
  const { times = null, while_input: input = null, level = true } = step;
  const kind = input !== null ? "input" : times === null ? "forever" : "times";
  return (
    <>
      <Choice
        label={t("program.repeat")}
        value={kind}
        options={(["times", "forever", "input"] as const).map((value) => ({
          value,
          label: t(`program.repeat.${value}`),
        }))}
        data-testid="step-repeat"
        onChange={(chosen) => {
          change({ ...step, ...LOOPS[chosen as keyof typeof LOOPS] });
        }}
      />
      {times !== null && (
        <Quantity
          label={t("program.count")}
          value={times}
          unit={{ symbol: "", factor: 1, digits: 0, step: 1 }}
          min={1}
          max={1e6}
          data-testid="step-times"
          onCommit={(value) => {
            change({ ...step, times: Math.round(value) });
          }}
        />
      )}
      {input !== null && (
        <>
          <Pin
            label={t("program.input")}
            pin={input}
            nameOf={inputText}
            onChange={(pin) => {
              change({ ...step, while_input: pin });
            }}
          />
          <Level
            level={level}
            onChange={(chosen) => {
              change({ ...step, level: chosen });
            }}
          />
        </>
      )}
    </>
  );
}
