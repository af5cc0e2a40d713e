/** As rqt_joint_trajectory_controller: drives a controller by a slider for each joint. */
import { useState } from "preact/hooks";
import { shownBox } from "../control-box";
import { choose, controllerOf, drive, goals, holdStill, speedScale } from "../driving";
import { guided } from "../guiding";
import { t } from "../i18n";
import { hasArm } from "../jog";
import { report } from "../notices";
import type { ControllerInfo } from "../protocol";
import { isOurController, withoutPrefix } from "../robots";
import { joints, status, unlessOffered } from "../store";
import { Button } from "../ui/button";
import { StopIcon } from "../ui/icons";
import { Select } from "../ui/select";
import { Slider } from "../ui/slider";
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
        {controller && <ControllerSelect controller={controller} />}
        <UnitSwitch />
      </header>
      {controller ? (
        <Drive controller={controller} />
      ) : (
        <p class="muted">{t("motion.noController")}</p>
      )}
      <div class="below-joints">
        <Undrivable />
        {controller && <Advice controller={controller} />}
      </div>
    </section>
  );
}

/** Return who moves the arm instead of its controllers, which run again after it. */
function whoHasArm(): string | null {
  if (guided.value !== null) return t("motion.guided");
  const by = shownBox.value?.taken_by ?? "";
  return by === "" ? null : t("motion.taken", { by });
}

/** Why nothing can be driven, where there is room for it: no control moves. */
function Advice({ controller }: { controller: ControllerInfo }) {
  const why = hasArm.value ? null : (whoHasArm() ?? advice(controller));
  return why === null ? null : (
    <p class="hint ellipsis" title={why}>
      {why}
    </p>
  );
}

function Drive({ controller }: { controller: ControllerInfo }) {
  const driven = goals.value;
  const moved = joints.value.filter((joint) => controller.joints.includes(joint.name));
  return (
    <>
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

function ourControllers(): readonly ControllerInfo[] {
  return (status.value?.controllers ?? []).filter(isOurController);
}

function ControllerSelect({ controller }: { controller: ControllerInfo }) {
  return (
    <Select
      class="grow"
      label={t("motion.controller")}
      value={controller.name}
      data-testid="controller-select"
      options={ourControllers().map((one) => {
        const why = obstacle(one);
        const name = withoutPrefix(one.name);
        // it runs again by itself, when the arm is released
        const waits = one.name === controller.name && whoHasArm() !== null;
        return {
          value: one.name,
          label: waits || why === null ? name : `${name} – ${why}`,
          disabled: why !== null,
        };
      })}
      onChange={choose}
    />
  );
}

function SpeedRow() {
  const [isStopping, setStopping] = useState(false);
  const stop = async () => {
    setStopping(true);
    const problem = await holdStill();
    setStopping(false);
    if (problem !== null) report("error", problem.message);
  };
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
        onClick={() => void stop()}
        {...unlessOffered("command_trajectory")}
      >
        <StopIcon />
        {t(isStopping ? "motion.stopping" : "motion.stop")}
      </Button>
    </div>
  );
}

/** Controllers that cannot be driven, and why: users look for them here. */
function Undrivable() {
  const others = ourControllers().filter((controller) => obstacle(controller) !== null);
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
