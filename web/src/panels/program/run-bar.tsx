/** Check, run, pause, step and stop; what the program does, and its preview. */
import { computed, signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { mayMove } from "../../driving";
import { t } from "../../i18n";
import {
  check,
  checkFailure,
  checkProgram,
  isChecking,
  showAt,
} from "../../program/checking";
import { approach, endApproach, start as away } from "../../program/approach";
import { steps } from "../../program/editor";
import {
  control,
  isRunning,
  refusal,
  requested,
  run,
  start,
  startHere,
} from "../../program/running";
import { pathText } from "../../program/steps";
import type { PlannedMotion, ProgramRun } from "../../protocol";
import { isReal, unlessOffered } from "../../store";
import { Badge, type Tone } from "../../ui/badge";
import { Button } from "../../ui/button";
import { HoldButton } from "../../ui/hold-button";
import { PauseIcon, PlayIcon, StepIcon, StopIcon } from "../../ui/icons";
import { whileHeld } from "../../ui/held";
import { fixed } from "../../ui/number-field";
import { Slider } from "../../ui/slider";
import { CheckIcon } from "./icons";

const TONES: Record<ProgramRun["state"], Tone> = {
  running: "accent",
  paused: "warning",
  succeeded: "ok",
  failed: "warning",
  stopped: "neutral",
};

/** A real robot runs the first program of a session only while somebody looks at it. */
const wasHeld = signal(false);
const mustHold = computed(() => isReal.value && !wasHeld.value);

function startHeld(): Promise<void> {
  wasHeld.value = true;
  return start();
}

export function RunBar() {
  const state = run.value?.state;
  const isPaused = state === "paused";
  const isEmpty = steps.value.length === 0;
  return (
    <section class="group" aria-label={t("program.run")}>
      <div class="row wrap" role="toolbar" aria-label={t("program.run")}>
        <Button
          disabled={isEmpty || isChecking.value || isRunning.value}
          data-testid="program-check"
          onClick={() => void checkProgram(requested())}
        >
          <CheckIcon />
          {t("program.check")}
        </Button>
        {state === "running" ? (
          <Button
            key="pause"
            data-testid="program-pause"
            onClick={() => void control("pause_run")}
          >
            <PauseIcon />
            {t("program.pause")}
          </Button>
        ) : mustHold.value && !isPaused && mayMove.value && !isEmpty ? (
          <HoldButton
            key="hold"
            data-testid="program-hold"
            onHeld={() => void startHeld()}
          >
            <PlayIcon />
            {t("program.holdToRun")}
          </HoldButton>
        ) : (
          <Button
            key="run"
            kind="primary"
            disabled={!mayMove.value || (isEmpty && !isPaused)}
            data-testid={isPaused ? "program-resume" : "program-run"}
            onClick={() => void (isPaused ? control("resume_run") : start())}
          >
            <PlayIcon />
            {t(isPaused ? "program.resume" : "program.run")}
          </Button>
        )}
        <Button
          disabled={!mayMove.value || state === "running" || (isEmpty && !isPaused)}
          data-testid="program-single"
          onClick={() => void (isPaused ? control("step_run") : startHere(true))}
        >
          <StepIcon />
          {t("program.single")}
        </Button>
        <Button
          disabled={!isRunning.value}
          data-testid="program-stop"
          onClick={() => void control("stop_run")}
        >
          <StopIcon />
          {t("program.stop")}
        </Button>
      </div>
      {!mayMove.value && <p class="hint">{t("program.needsDrive")}</p>}
      {away.value !== null && !isRunning.value && <Away />}
      <RunState />
      <Findings />
      {check.value && !isRunning.value && <Preview motion={check.value.motion} />}
    </section>
  );
}

/** The arm is elsewhere: the way to the start, or the program from here. */
function Away() {
  useEffect(() => endApproach, []);
  return (
    <div class="away" data-testid="program-away">
      <p role="status">{t("program.away")}</p>
      <div class="row wrap">
        <button
          type="button"
          class="button primary"
          disabled={!mayMove.value}
          data-testid="program-approach"
          {...whileHeld(() => void approach(), endApproach)}
          {...unlessOffered("move_joints")}
        >
          {t("program.holdToStart")}
        </button>
        <Button
          disabled={!mayMove.value}
          data-testid="program-run-here"
          onClick={() => void startHere()}
        >
          {t("program.runFromHere")}
        </Button>
      </div>
    </div>
  );
}

function RunState() {
  const now = run.value;
  if (now === null) return null;
  const { step = [], text = "", error = "", time = 0 } = now;
  return (
    <div role="status" class="run-state">
      <Badge tone={TONES[now.state]} data-testid="program-state">
        {t(`program.state.${now.state}`)}
      </Badge>
      <span class="grow ellipsis" data-testid="program-now">
        {now.program}
        {step.length > 0 && ` · ${pathText(step)} ${text}`}
      </span>
      <span class="muted">{fixed(time, 1)} s</span>
      {error !== "" && (
        <p class="refusal" data-testid="program-error">
          {error}
        </p>
      )}
    </div>
  );
}

/** What a check found, and why requests were refused. */
function Findings() {
  const reason = refusal.value ?? checkFailure.value;
  const found = check.value;
  const first = found?.problems[0];
  return (
    <div role="status">
      {reason !== null && (
        <p class="refusal" data-testid="program-refusal">
          {reason}
        </p>
      )}
      {first && (
        <p class="refusal" data-testid="program-problem">
          {first.step.length > 0
            ? t("program.wrong", { step: pathText(first.step), reason: first.text })
            : first.text}
        </p>
      )}
      {found && !first && (
        <p class="hint" data-testid="program-fine">
          {t("program.fine", { time: fixed(found.motion.times.at(-1) ?? 0, 1) })}
        </p>
      )}
    </div>
  );
}

/** A slider over the time of the plan: the ghost goes through it. */
function Preview({ motion }: { motion: PlannedMotion }) {
  const [time, setTime] = useState(0);
  useEffect(() => {
    setTime(0);
  }, [motion]);
  const end = motion.times.at(-1) ?? 0;
  if (end === 0) return null;
  return (
    <div class="row">
      <span class="caption">{t("program.preview")}</span>
      <Slider
        label={t("program.preview")}
        value={time}
        min={0}
        max={end}
        step={end / 200}
        valueText={`${fixed(time, 1)} s`}
        data-testid="program-preview"
        onInput={(at) => {
          setTime(at);
          showAt(motion, at);
        }}
      />
      <span class="figure">{fixed(time, 1)} s</span>
    </div>
  );
}
