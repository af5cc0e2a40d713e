/** The pose of tool0 as numbers: they follow it, and typed ones are a target. */
import { Fragment } from "preact";
import { useRef } from "preact/hooks";
import { mayMove } from "../../driving";
import { t } from "../../i18n";
import { fromRotationVector, fromRpy, toRotationVector, toRpy } from "../../kinematics";
import type { Pose } from "../../kinematics";
import { useLive } from "../../live";
import { offers, unlessOffered } from "../../store";
import {
  aimTool,
  choosePosture,
  chosenBranch,
  forgetTarget,
  go,
  nameOf,
  posture,
  postures,
  target,
  unreachable,
  WAYS,
  way,
} from "../../tool-target";
import { fromNumberFrame, inNumberFrame } from "../../number-frame";
import { toolPose } from "../../tool";
import { Button, IconButton } from "../../ui/button";
import { SignalChoice } from "../../ui/choice";
import { UndoIcon } from "../../ui/icons";
import { remembered } from "../../ui/memory";
import { fixed, NumberField } from "../../ui/number-field";
import { Select } from "../../ui/select";
import { angleUnit, MILLIMETRES, unitOf } from "../../units";
import type { Vector } from "../../urdf";
import { FrameSwitch } from "../frame-switch";

const ROTATIONS = ["rpy", "vector"] as const;
const rotation = remembered("pose-rotation", ROTATIONS, "rpy");
/** The range that the server accepts [m]. */
const FARTHEST = 1000;
const NAMES = {
  rpy: ["roll", "pitch", "yaw"],
  vector: ["rx", "ry", "rz"],
} as const;

/** Return position [m] and rotation [rad] of a pose of the root, as they are shown. */
function numbersOf(pose: Pose): readonly number[] {
  const { p, R } = inNumberFrame(pose);
  return [...p, ...(rotation.value === "rpy" ? toRpy(R) : toRotationVector(R))];
}

/** Return the pose in the root of such numbers. */
function poseOfNumbers(numbers: readonly number[]): Pose {
  const [x = 0, y = 0, z = 0, a = 0, b = 0, c = 0] = numbers;
  const angles: Vector = [a, b, c];
  const R = rotation.value === "rpy" ? fromRpy(angles) : fromRotationVector(angles);
  return fromNumberFrame({ p: [x, y, z], R });
}

export function PosePanel() {
  const wanted = target.value;
  const angle = unitOf("revolute", angleUnit.value);
  const units = [MILLIMETRES, MILLIMETRES, MILLIMETRES, angle, angle, angle];
  const labels = ["x", "y", "z", ...NAMES[rotation.value]];
  const fields = useRef<(HTMLInputElement | null)[]>([]);
  const canAim = offers("solve_inverse_kinematics") && offers("move_to", "move_linear");
  const numbers = numbersOf(wanted ?? toolPose());

  useLive(() => {
    if (target.peek() !== null) return;
    numbersOf(toolPose()).forEach((value, index) => {
      const [field, unit] = [fields.current[index], units[index]];
      if (!field || !unit || document.activeElement === field) return;
      if (field.ariaInvalid === "true") return;
      field.value = fixed(value * unit.factor, unit.digits);
      field.setAttribute("aria-valuenow", String(value * unit.factor));
    });
  });

  return (
    <>
      <div class="row">
        <FrameSwitch testId="tool-frame" />
        <SignalChoice
          label={t("tool.rotation")}
          of={rotation}
          among={ROTATIONS}
          name={(value) => t(`tool.rotation.${value}`)}
          testId="pose-rotation"
        />
        {wanted !== null && (
          <IconButton
            label={t("tool.forget")}
            data-testid="tool-forget"
            onClick={forgetTarget}
          >
            <UndoIcon />
          </IconButton>
        )}
      </div>
      <div
        class={`tool-pose ${wanted === null ? "" : "aimed"}`}
        role="group"
        aria-label={t(wanted === null ? "tool.pose" : "tool.target")}
        data-testid="tool-pose"
      >
        {labels.map((label, index) => {
          const unit = units[index] ?? MILLIMETRES;
          const limit = index < 3 ? FARTHEST : 2 * Math.PI;
          return (
            <Fragment key={label}>
              <NumberField
                label={`${t("tool.title")} ${label}`}
                prefix={label}
                unit={unit.symbol}
                showsUnit={false}
                digits={unit.digits}
                min={-limit * unit.factor}
                max={limit * unit.factor}
                step={unit.step}
                value={(numbers[index] ?? 0) * unit.factor}
                disabled={!canAim}
                input={{
                  get current() {
                    return fields.current[index] ?? null;
                  },
                  set current(field) {
                    fields.current[index] = field;
                  },
                }}
                data-testid={`tool-${String(index)}`}
                onCommit={(shown) => {
                  const now = [...numbersOf(target.peek() ?? toolPose())];
                  now[index] = shown / unit.factor;
                  aimTool(poseOfNumbers(now));
                }}
              />
              {index % 3 === 2 && <span class="unit">{unit.symbol}</span>}
            </Fragment>
          );
        })}
      </div>
      {canAim && <Target />}
    </>
  );
}

/** How to go to the target, and the posture in which it is reached. */
function Target() {
  const isAimed = target.value !== null;
  const found = postures.value;
  const why = isAimed ? unreachable.value : null;
  return (
    <>
      <div class="row">
        <SignalChoice
          label={t("tool.way")}
          of={way}
          among={WAYS}
          name={(value) => t(`tool.way.${value}`)}
          testId="tool-way"
        />
        <Button
          class="grow"
          kind="primary"
          disabled={!isAimed || why !== null || !mayMove.value}
          data-testid="tool-go"
          onClick={() => void go()}
          {...unlessOffered(way.value === "joint" ? "move_to" : "move_linear")}
        >
          {t("tool.go")}
        </Button>
      </div>
      {isAimed && found.length > 0 && way.value === "joint" && (
        <Select
          class="grow"
          label={t("tool.posture")}
          value={chosenBranch.value === null ? "" : nameOf(posture.value?.branch ?? {})}
          data-testid="tool-posture"
          options={[
            { value: "", label: t("tool.nearest", { count: found.length }) },
            ...found.map(({ branch }) => ({
              value: nameOf(branch),
              label: [
                t(`tool.shoulder.${branch.shoulder ?? "left"}`),
                t(`tool.elbow.${branch.elbow ?? "up"}`),
                t(`tool.wrist.${branch.wrist ?? "no_flip"}`),
              ].join(" · "),
            })),
          ]}
          onChange={(value) => {
            choosePosture(value === "" ? null : value);
          }}
        />
      )}
      {why !== null && (
        <p class="refusal" role="alert" data-testid="tool-unreachable">
          {why}
        </p>
      )}
    </>
  );
}
