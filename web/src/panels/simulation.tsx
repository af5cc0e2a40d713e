/** Time: run, pause, step, reset, speed and real-time factor. */
import { signal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { sendRequest } from "../connection";
import { t } from "../i18n";
import { useLive } from "../live";
import type { Status } from "../protocol";
import { status, unlessOffered, view } from "../store";
import { IconButton } from "../ui/button";
import { PauseIcon, PlayIcon, ResetIcon, StepIcon } from "../ui/icons";
import { Select } from "../ui/select";
import { confirm } from "./confirmation";

/** Fraction of the requested speed. */
const BEHIND = 0.95;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];
const STEPS = [1, 10, 100, 1000];

const ticks = signal(10);

export function RunButton() {
  return status.value?.paused === true ? (
    <IconButton
      label={t("simulation.resume")}
      data-testid="sim-resume"
      onClick={() => void sendRequest("resume")}
      {...unlessOffered("resume")}
    >
      <PlayIcon />
    </IconButton>
  ) : (
    <IconButton
      label={t("simulation.pause")}
      data-testid="sim-pause"
      onClick={() => void sendRequest("pause")}
      {...unlessOffered("pause")}
    >
      <PauseIcon />
    </IconButton>
  );
}

export function TimeControls() {
  const now = status.value;
  const paused = now?.paused ?? false;
  return (
    <div class="buttons">
      <IconButton
        label={t("simulation.step")}
        data-testid="sim-step"
        disabled={!paused}
        onClick={() => void sendRequest("step", { ticks: ticks.value })}
        {...unlessOffered("step")}
      >
        <StepIcon />
      </IconButton>
      {paused && <StepLength />}
      <IconButton
        label={t("simulation.reset")}
        data-testid="sim-reset"
        onClick={() => {
          confirm(t("confirm.resetAll"), t("confirm.reset"), () => {
            void sendRequest("reset");
          });
        }}
        {...unlessOffered("reset")}
      >
        <ResetIcon />
      </IconButton>
      <Speed factor={now?.speed ?? null} />
    </div>
  );
}

export function Readings() {
  const now = status.value;
  return (
    <dl class="readings">
      <SimulatedTime />
      <Reading
        label={t("simulation.factorShort")}
        title={t("simulation.factor")}
        testId="sim-rtf"
        value={`${(now?.real_time_factor ?? 0).toFixed(2)}×`}
        isWarning={isBehind(now)}
      />
      <Reading
        label={t("simulation.lateShort")}
        title={t("simulation.late")}
        testId="sim-late"
        value={t("simulation.perSecond", { count: now?.late_ticks ?? 0 })}
      />
    </dl>
  );
}

/** Whether the simulation does not reach the requested speed. */
function isBehind(now: Status | null): boolean {
  if (now === null || now.paused || now.speed === null) return false;
  return now.late_ticks > 0 && now.real_time_factor < BEHIND * now.speed;
}

function StepLength() {
  const period = view.value?.control_period ?? 0.001;
  return (
    <Select
      label={t("simulation.stepBy")}
      value={String(ticks.value)}
      data-testid="sim-step-length"
      options={STEPS.map((count) => ({
        value: String(count),
        label: `${String(Number((count * period * 1000).toPrecision(6)))} ms`,
      }))}
      onChange={(value) => {
        ticks.value = Number(value);
      }}
    />
  );
}

function Speed({ factor }: { factor: number | null }) {
  const offered = new Set(SPEEDS);
  if (factor !== null) offered.add(factor);
  const options = [...offered]
    .sort((a, b) => a - b)
    .map((value) => ({ value: String(value), label: `${String(value)}×` }));
  return (
    <Select
      label={t("simulation.speed")}
      value={String(factor)}
      data-testid="sim-speed"
      options={
        factor === null
          ? [
              ...options,
              { value: "null", label: t("simulation.fastest"), disabled: true },
            ]
          : options
      }
      onChange={(value) => void sendRequest("set_speed", { factor: Number(value) })}
      {...unlessOffered("set_speed")}
    />
  );
}

export function SimulatedTime() {
  const text = useRef<HTMLElement | null>(null);
  useLive((frame) => {
    if (text.current) text.current.textContent = `${frame.time.toFixed(2)} s`;
  });
  return (
    <div title={t("simulation.time")}>
      <dt class="visually-hidden">{t("simulation.time")}</dt>
      <dd class="time" ref={text} data-testid="sim-time" />
    </div>
  );
}

function Reading(props: {
  label: string;
  title: string;
  value: string;
  testId: string;
  isWarning?: boolean;
}) {
  return (
    <div title={props.title} class={props.isWarning === true ? "warning" : ""}>
      <dt>{props.label}</dt>
      <dd data-testid={props.testId}>{props.value}</dd>
    </div>
  );
}
