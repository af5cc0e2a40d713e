/** Jogging: buttons that move the tool while they are held, and other devices for it. */
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { mayMove } from "../../driving";
import { t } from "../../i18n";
import {
  FASTEST,
  hold,
  jogSpeed,
  jogStep,
  release,
  SLOWEST,
  step,
  STEPS,
} from "../../jog";
import type { Direction } from "../../jog";
import { gamepad, watchGamepad } from "../../jogging/gamepad";
import { watchKeys } from "../../jogging/keys";
import {
  connectSpaceMouse,
  disconnectSpaceMouse,
  hasHid,
  spaceMouse,
} from "../../jogging/spacemouse";
import { stopsAtObstacles } from "../../planning/check";
import { offers } from "../../store";
import { gizmoMoves, MOVES, showGizmo } from "../../tool-target";
import { jogsInTool, numberFrame, toolFrame } from "../../tool";
import { Segmented, SignalChoice } from "../../ui/choice";
import { Select } from "../../ui/select";
import { Slider } from "../../ui/slider";
import { whileHeld } from "../../ui/held";
import { SignalToggle, Toggle } from "../../ui/toggle";
import { MILLIMETRES, unitOf, angleUnit } from "../../units";
import { fixed } from "../../ui/number-field";

const AXES = ["x", "y", "z", "rx", "ry", "rz"] as const;
const usesKeys = signal(false);
const usesGamepad = signal(false);

export function JogPanel() {
  const now = Math.round(jogSpeed.value * 1000);
  return (
    <div class="jog" role="group" aria-label={t("jog.title")}>
      <div class="row">
        <Segmented
          label={t("jog.frame")}
          value={toolFrame.value}
          choices={([numberFrame.value, "tool"] as const).map((value) => ({
            value,
            label: t(`tool.frame.${value}`),
            testId: `jog-frame-${value}`,
          }))}
          onChange={(value) => {
            jogsInTool.value = value === "tool";
          }}
        />
        <StepSelect />
      </div>
      <div class="jog-buttons">
        {AXES.map((name, axis) => (
          <div key={name}>
            <JogButton name={name} axis={axis} sign={1} />
            <JogButton name={name} axis={axis} sign={-1} />
          </div>
        ))}
      </div>
      <div class="row speed">
        <span class="caption">{t("jog.speed")}</span>
        <Slider
          label={t("jog.speed")}
          valueText={`${String(now)} mm/s`}
          min={SLOWEST * 1000}
          max={FASTEST * 1000}
          step={5}
          value={now}
          data-testid="jog-speed"
          onInput={(value) => {
            jogSpeed.value = Math.round(value) / 1000;
          }}
        />
        <span class="figure">{now} mm/s</span>
      </div>
      <Devices />
    </div>
  );
}

function StepSelect() {
  const angle = unitOf("revolute", angleUnit.value);
  return (
    <Select
      class="grow"
      label={t("jog.step")}
      value={jogStep.value === null ? "" : String(jogStep.value)}
      data-testid="jog-step"
      options={[
        { value: "", label: t("jog.continuous") },
        ...STEPS.map(([along, about], index) => ({
          value: String(index),
          label: `${fixed(along * MILLIMETRES.factor, index === 0 ? 1 : 0)} mm, ${fixed(
            about * angle.factor,
            angle.digits,
          )} ${angle.symbol}`,
        })),
      ]}
      onChange={(value) => {
        jogStep.value = value === "" ? null : Number(value);
      }}
    />
  );
}

interface JogButtonProps {
  name: (typeof AXES)[number];
  axis: number;
  sign: 1 | -1;
}

function JogButton({ name, axis, sign }: JogButtonProps) {
  const source = `button ${name} ${String(sign)}`;
  const direction = AXES.map((_, i) => (i === axis ? sign : 0)) as unknown as Direction;
  const press = () => {
    if (jogStep.value === null) hold(source, direction);
    else step(direction);
  };
  const end = () => {
    release(source);
  };
  useEffect(() => end, []);
  return (
    <button
      type="button"
      class="button"
      aria-label={t("jog.along", { axis: `${name}${sign > 0 ? "+" : "−"}` })}
      disabled={!mayMove.value}
      data-testid={`jog-${name}-${sign > 0 ? "plus" : "minus"}`}
      {...whileHeld(press, end)}
    >
      {name}
      {sign > 0 ? "+" : "−"}
    </button>
  );
}

/** Other ways to jog and to aim. */
function Devices() {
  useEffect(() => (usesKeys.value ? watchKeys() : undefined), [usesKeys.value]);
  useEffect(
    () => (usesGamepad.value ? watchGamepad() : undefined),
    [usesGamepad.value],
  );
  return (
    <>
      <div class="row wrap">
        <SignalToggle label={t("jog.gizmo")} of={showGizmo} data-testid="tool-gizmo" />
        {showGizmo.value && (
          <SignalChoice
            label={t("jog.gizmoMoves")}
            of={gizmoMoves}
            among={MOVES}
            name={(value) => t(`jog.gizmo.${value}`)}
            testId="gizmo"
          />
        )}
        {offers("check_motion") && (
          <SignalToggle
            label={t("jog.stopsAtObstacles")}
            of={stopsAtObstacles}
            data-testid="jog-obstacles"
          />
        )}
        <SignalToggle
          label={t("jog.keyboard")}
          of={usesKeys}
          data-testid="jog-keyboard"
        />
        <SignalToggle
          label={t("jog.gamepad")}
          of={usesGamepad}
          data-testid="jog-gamepad"
        />
        {hasHid() && (
          <Toggle
            label="SpaceMouse"
            checked={spaceMouse.value !== null}
            data-testid="jog-spacemouse"
            onChange={(used) => {
              if (used) void connectSpaceMouse();
              else disconnectSpaceMouse();
            }}
          />
        )}
      </div>
      {usesKeys.value && <p class="hint">{t("jog.keyboardHint")}</p>}
      {usesGamepad.value && (
        <p class="hint" data-testid="jog-gamepad-name">
          {gamepad.value === null
            ? t("jog.gamepadNone")
            : t(gamepad.value.isUsed ? "jog.gamepadHint" : "jog.gamepadUnknown", {
                name: gamepad.value.name,
              })}
        </p>
      )}
    </>
  );
}
