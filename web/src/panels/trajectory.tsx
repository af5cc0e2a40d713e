/** rqt_joint_trajectory_controller's work: drive a controller by a slider for each joint. */
import {
  canDrive,
  chosenController,
  controllerOf,
  disable,
  drive,
  enable,
  endReason,
  goals,
  holdStill,
  speedScale,
} from "../driving";
import { t } from "../i18n";
import { report } from "../notices";
import type { ControllerInfo } from "../protocol";
import { joints, status } from "../store";
import { Button } from "../ui/button";
import { StopIcon } from "../ui/icons";
import { Select } from "../ui/select";
import { Slider } from "../ui/slider";
import { Toggle } from "../ui/toggle";
import { advice, obstacle } from "./obstacle";
import { JointRow } from "./joint-row";
import { UnitSwitch } from "./unit-switch";

export function TrajectoryPanel() {
  const now = status.value;
  if (now === null) return null;
  const controller = controllerOf(now);
  return (
    <section class="group" aria-labelledby="trajectory-title">
      <header>
        <h2 id="trajectory-title">{t("motion.joints")}</h2>
        <UnitSwitch />
      </header>
      {controller ? (
        <Drive controller={controller} />
      ) : (
        <p class="muted">{t("motion.noController")}</p>
      )}
      <Undrivable />
    </section>
  );
}

function Drive({ controller }: { controller: ControllerInfo }) {
  const driven = goals.value;
  const moved = joints.value.filter((joint) => controller.joints.includes(joint.name));
  const hint = endReason.value;
  return (
    <>
      <div class="row">
        <ControllerSelect controller={controller} />
        <Toggle
          label={t("motion.enable")}
          checked={driven !== null}
          disabled={!canDrive(controller) || status.value?.stopped === true}
          data-testid="enable-toggle"
          onChange={(checked) => {
            if (checked) enable();
            else disable();
          }}
        />
      </div>
      <p
        class={`hint ${hint !== null && driven === null ? "ended" : ""}`}
        role="status"
        data-testid="driving-state"
      >
        {driven !== null
          ? t("motion.driving")
          : hint !== null
            ? t(`motion.ended.${hint}`)
            : advice(controller)}
      </p>
      <ul class={`joints ${driven === null ? "monitor" : ""}`}>
        {moved.map((joint) => (
          <JointRow
            key={joint.name}
            joint={joint}
            goal={driven?.get(joint.name) ?? null}
            onChange={(position) => {
              drive(joint.name, position);
            }}
          />
        ))}
      </ul>
      <SpeedRow />
    </>
  );
}

function ControllerSelect({ controller }: { controller: ControllerInfo }) {
  return (
    <Select
      class="grow"
      label={t("motion.controller")}
      value={controller.name}
      data-testid="controller-select"
      options={(status.value?.controllers ?? []).map((one) => {
        const why = obstacle(one);
        return {
          value: one.name,
          label: why === null ? one.name : `${one.name} – ${why}`,
          disabled: why !== null,
        };
      })}
      onChange={(name) => {
        disable();
        endReason.value = null;
        chosenController.value = name;
      }}
    />
  );
}

function SpeedRow() {
  const percent = Math.round(speedScale.value * 100);
  return (
    <div class="row speed">
      <span class="caption">{t("motion.speed")}</span>
      <Slider
        label={t("motion.speed")}
        valueText={`${String(percent)} %`}
        min={1}
        max={100}
        step={1}
        value={percent}
        data-testid="speed-scale"
        onInput={(value) => {
          speedScale.value = Math.round(value) / 100;
        }}
      />
      <span class="figure">{percent} %</span>
      <Button
        title={t("motion.stopLong")}
        data-testid="hold-still"
        onClick={() => {
          void holdStill().then((problem) => {
            if (problem !== null) report("error", problem.message);
          });
        }}
      >
        <StopIcon />
        {t("motion.stop")}
      </Button>
    </div>
  );
}

/** Those that cannot be driven, and why: a person looks for them here. */
function Undrivable() {
  const others = (status.value?.controllers ?? []).filter(
    (controller) => obstacle(controller) !== null,
  );
  if (others.length === 0) return null;
  return (
    <details class="others">
      <summary>{t("motion.undrivable", { count: others.length })}</summary>
      <ul>
        {others.map((controller) => (
          <li key={controller.name}>
            <code>{controller.name}</code>{" "}
            <span class="muted">{obstacle(controller)}</span>
          </li>
        ))}
      </ul>
    </details>
  );
}
