/** A move: its target, taught or typed, speed, acceleration and blend. */
import { t } from "../../i18n";
import { change } from "../../program/editor";
import type { MoveStep } from "../../program/steps";
import { presentPose, taught } from "../../program/teaching";
import { DEFAULTS, jointUnit, MM_PER_S, MM_PER_S2 } from "../../program/words";
import { withoutPrefix } from "../../robots";
import { joints, status } from "../../store";
import { Button } from "../../ui/button";
import { NumberField } from "../../ui/number-field";
import { angleUnit, limitsOf, MILLIMETRES, unitOf } from "../../units";
import { PoseFields } from "../pose-fields";
import { Choice, Quantity, Row } from "./fields";

type Target = "joints" | "pose" | "named_pose";

function targetOf(step: MoveStep): Target {
  if (step.named_pose != null) return "named_pose";
  return step.pose ? "pose" : "joints";
}

/** Return the step with another kind of target: where the arm is now, or a named pose. */
function aimed(step: MoveStep, target: string): MoveStep {
  const none = { joints: null, pose: null, named_pose: null };
  if (target === "named_pose") {
    const name = status.peek()?.poses[0]?.name ?? "home";
    return { ...step, ...none, named_pose: name };
  }
  if (target === "pose") {
    return { ...step, ...none, pose: presentPose() ?? { xyz: [0, 0, 0] } };
  }
  return taught(step);
}

export function MoveFields({ step }: { step: MoveStep }) {
  const target = targetOf(step);
  const isJoint = step.kind === "move_joint";
  const { speed, acceleration } = DEFAULTS[step.kind];
  return (
    <>
      <Row label={t("program.label")}>
        <span class="field grow">
          <input
            type="text"
            maxLength={200}
            value={step.label ?? ""}
            placeholder={t("program.labelHint")}
            aria-label={t("program.label")}
            data-testid="step-label"
            onChange={(event) => {
              change({ ...step, label: event.currentTarget.value.trim() });
            }}
          />
        </span>
      </Row>
      <Choice
        label={t("program.target")}
        value={target}
        options={(["joints", "pose", "named_pose"] as const).map((value) => ({
          value,
          label: t(`program.target.${value}`),
        }))}
        data-testid="step-target"
        onChange={(chosen) => {
          change(aimed(step, chosen));
        }}
      />
      {target === "named_pose" ? (
        <NamedPose step={step} />
      ) : (
        <>
          <Button
            data-testid="step-teach"
            onClick={() => {
              change(aimed(step, target));
            }}
          >
            {t("program.teach")}
          </Button>
          {step.pose ? <Pose step={step} pose={step.pose} /> : <Joints step={step} />}
        </>
      )}
      <Quantity
        label={t("program.speed")}
        value={step.speed ?? speed}
        unit={isJoint ? jointUnit("/s") : MM_PER_S}
        min={0.001}
        max={100}
        data-testid="step-speed"
        onCommit={(value) => {
          change({ ...step, speed: value });
        }}
      />
      <Quantity
        label={t("program.acceleration")}
        value={step.acceleration ?? acceleration}
        unit={isJoint ? jointUnit("/s²") : MM_PER_S2}
        min={0.001}
        max={1000}
        data-testid="step-acceleration"
        onCommit={(value) => {
          change({ ...step, acceleration: value });
        }}
      />
      <Quantity
        label={t("program.blend")}
        value={step.blend ?? 0}
        unit={MILLIMETRES}
        min={0}
        max={10}
        data-testid="step-blend"
        onCommit={(value) => {
          change({ ...step, blend: value });
        }}
      />
    </>
  );
}

function NamedPose({ step }: { step: MoveStep }) {
  const name = step.named_pose ?? "";
  const known = status.value?.poses.map((pose) => pose.name) ?? [];
  return (
    <Choice
      label={t("program.target.named_pose")}
      value={name}
      options={[...new Set([...known, name])].map((value) => ({ value, label: value }))}
      data-testid="step-named-pose"
      onChange={(chosen) => {
        change({ ...step, named_pose: chosen });
      }}
    />
  );
}

function Pose({ step, pose }: { step: MoveStep; pose: NonNullable<MoveStep["pose"]> }) {
  return (
    <PoseFields
      value={{ position: pose.xyz, rpy: pose.rpy ?? [0, 0, 0] }}
      link={pose.relative_to ?? null}
      testId="step-pose"
      onChange={({ position, rpy }) => {
        change({ ...step, pose: { ...pose, xyz: [...position], rpy: [...rpy] } });
      }}
    />
  );
}

function Joints({ step }: { step: MoveStep }) {
  const unit = unitOf("revolute", angleUnit.value);
  const all = step.joints ?? {};
  return (
    <div class="step-joints" role="group" aria-label={t("program.target.joints")}>
      {Object.entries(all).map(([name, value]) => {
        const info = joints.value.find((joint) => joint.name === name);
        const [lower, upper] = info ? limitsOf(info) : [-Infinity, Infinity];
        return (
          <label key={name}>
            <code class="ellipsis">{withoutPrefix(name)}</code>
            <NumberField
              label={name}
              unit={unit.symbol}
              value={value * unit.factor}
              digits={unit.digits}
              min={lower * unit.factor}
              max={upper * unit.factor}
              step={unit.step}
              data-testid={`step-joint-${name}`}
              onCommit={(shown) => {
                const changed = { ...all, [name]: shown / unit.factor };
                change({ ...step, joints: changed });
              }}
            />
          </label>
        );
      })}
    </div>
  );
}
