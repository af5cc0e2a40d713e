import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { connection } from "../connection";
import { mayMove } from "../driving";
import { t } from "../i18n";
import type { GripperInfo, GripperState, ErrorInfo } from "../protocol";
import { isLive, status } from "../store";
import { Badge } from "../ui/badge";
import type { Tone } from "../ui/badge";
import { Button } from "../ui/button";
import { fixed, NumberField } from "../ui/number-field";
import { share, Slider } from "../ui/slider";

const TONES: Record<GripperState["motion"], Tone> = {
  moving: "accent",
  at_target: "neutral",
  holding_inside: "ok",
  holding_outside: "ok",
  blocked: "warning",
  idle: "warning",
};

/** Return the state of a gripper as text. */
export function describeGripper({ motion, width }: GripperState): string {
  if (motion !== "holding_inside" && motion !== "holding_outside") {
    return t(`gripper.${motion}`);
  }
  if (width === null) return t("gripper.holding");
  return t(`gripper.${motion}`, { width: fixed(width * 1000, 1) });
}

interface GripperPanelProps {
  gripper: GripperInfo;
  /** Whether the title says which gripper it is. */
  isNamed: boolean;
}

export function GripperPanel({ gripper, isNamed }: GripperPanelProps) {
  const now = status.value?.grippers.find((state) => state.name === gripper.name);
  const largest = gripper.max_opening * 1000;
  // the pads of a gripper that is open as wide as it can may be a little farther apart
  const actual = Math.min((now?.opening ?? 0) * 1000, largest);
  // mm: the dragged or sent value until it is reached; otherwise the actual one
  const [dragged, setDragged] = useState<number | null>(null);
  const [sent, setSent] = useState<number | null>(null);
  const [speed, setSpeed] = useState(gripper.max_speed);
  const [force, setForce] = useState(gripper.max_force);
  const [problem, setProblem] = useState<ErrorInfo | null>(null);
  const marker = useRef<HTMLDivElement | null>(null);
  useLayoutEffect(() => {
    marker.current?.style.setProperty("--actual-at", String(share(actual, 0, largest)));
  });

  useEffect(() => {
    if (now?.motion === "at_target" || now?.motion === "idle") setSent(null);
  }, [now?.motion]);

  const grip = (opening: number) => {
    setDragged(null);
    setSent(opening);
    void connection
      .request("grip", {
        gripper: gripper.name,
        opening: opening / 1000,
        ...(hasDrive && { speed, force }),
      })
      .then((refused) => {
        setProblem(refused);
        if (refused) setSent(null);
      });
  };
  const disabled = !mayMove.value;
  const hasDrive = isLive.value;
  const opening = dragged ?? sent ?? actual;
  const named = (label: string) => `${gripper.name}: ${label}`;

  return (
    <section class="group" aria-label={named(t("gripper.title"))}>
      <header>
        <h2>
          {t("gripper.title")} {isNamed && <code class="muted">{gripper.name}</code>}
        </h2>
        {now && hasDrive && (
          <span role="status" title={`gOBJ ${String(now.gobj)}`}>
            <Badge tone={TONES[now.motion]} data-testid="gripper-state">
              {describeGripper(now)}
            </Badge>
          </span>
        )}
        <span class="header-buttons">
          <Button
            disabled={disabled}
            data-testid="gripper-open"
            onClick={() => {
              grip(largest);
            }}
          >
            {t("gripper.open")}
          </Button>
          <Button
            disabled={disabled}
            data-testid="gripper-close"
            onClick={() => {
              grip(0);
            }}
          >
            {t("gripper.close")}
          </Button>
        </span>
      </header>
      <div class="row labelled">
        <span class="caption">{t("gripper.opening")}</span>
        <Slider
          label={named(t("gripper.opening"))}
          valueText={`${fixed(opening, 1)} mm`}
          min={0}
          max={largest}
          step={1}
          value={opening}
          disabled={disabled}
          root={marker}
          data-testid="gripper-opening"
          onInput={setDragged}
          onChange={grip}
        />
        <NumberField
          label={named(t("gripper.opening"))}
          unit="mm"
          digits={1}
          min={0}
          max={largest}
          step={1}
          value={opening}
          disabled={disabled}
          data-testid="gripper-opening-field"
          onCommit={grip}
        />
      </div>
      {hasDrive && (
        <>
          <Setting
            caption={t("gripper.speed")}
            label={named(t("gripper.speed"))}
            unit="mm/s"
            min={gripper.min_speed * 1000}
            max={gripper.max_speed * 1000}
            value={speed * 1000}
            testId="gripper-speed"
            onChange={(value) => {
              setSpeed(value / 1000);
            }}
          />
          <Setting
            caption={t("gripper.force")}
            label={named(t("gripper.force"))}
            unit="N"
            min={gripper.min_force}
            max={gripper.max_force}
            value={force}
            testId="gripper-force"
            onChange={setForce}
          />
        </>
      )}
      {problem && (
        <p class="refusal" role="alert" data-testid="gripper-refusal">
          {problem.message}
        </p>
      )}
    </section>
  );
}

interface SettingProps {
  caption: string;
  label: string;
  unit: string;
  min: number;
  max: number;
  value: number;
  testId: string;
  onChange: (value: number) => void;
}

/** A setting of the drive for the next motion; nothing, if there is no choice. */
function Setting({ caption, testId, onChange, ...props }: SettingProps) {
  const { label, unit, min, max, value } = props;
  if (max <= min) return null;
  return (
    <div class="row labelled">
      <span class="caption">{caption}</span>
      <Slider
        label={label}
        valueText={`${fixed(value, 0)} ${unit}`}
        min={min}
        max={max}
        step={1}
        value={value}
        data-testid={testId}
        onInput={onChange}
      />
      <NumberField {...props} digits={0} step={1} onCommit={onChange} />
    </div>
  );
}
