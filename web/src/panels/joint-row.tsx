/** One joint: its slider, its commanded value as a number, and its actual position. */
import type { Signal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { holdStill } from "../driving";
import { frames } from "../frames";
import { language, t } from "../i18n";
import { useLive } from "../live";
import type { JointInfo } from "../protocol";
import { withoutPrefix } from "../robots";
import { isReal, jointIndex, view } from "../store";
import { fixed, NumberField } from "../ui/number-field";
import { placeThumb, share, Slider } from "../ui/slider";
import { angleUnit, limitsOf, spanOf, unitOf } from "../units";

interface JointRowProps {
  joint: JointInfo;
  /** Commanded position [rad | m]; null: the slider follows the joint. */
  goal: Signal<number> | null;
  /** Whether the user may move a slider that follows. */
  editable?: boolean;
  onChange: (position: number) => void;
}

/** Whether the user is typing, or has to correct the input. */
function isEdited(field: HTMLInputElement): boolean {
  return document.activeElement === field || field.ariaInvalid === "true";
}

export function JointRow({ joint, goal, editable = false, onChange }: JointRowProps) {
  const root = useRef<HTMLDivElement | null>(null);
  const slider = useRef<HTMLInputElement | null>(null);
  const field = useRef<HTMLInputElement | null>(null);
  const actual = useRef<HTMLElement | null>(null);
  const index = jointIndex.value.get(joint.name) ?? -1;
  const unit = unitOf(joint.type, angleUnit.value);
  const [lower, upper] = spanOf(joint);
  const min = lower * unit.factor;
  const max = upper * unit.factor;
  const position = () => frames.latest?.position[index] ?? 0;
  const shown = (goal === null ? position() : goal.value) * unit.factor;
  const name = view.value?.robot.part_names[joint.name]?.[language.value];
  const say = (value: number) => `${fixed(value, unit.digits)} ${unit.symbol}`;

  useLive((frame) => {
    const value = (frame.position[index] ?? 0) * unit.factor;
    root.current?.style.setProperty("--actual-at", String(share(value, min, max)));
    if (actual.current) actual.current.textContent = fixed(value, unit.digits);
    if (goal !== null || slider.current === null || root.current === null) return;
    slider.current.value = String(value);
    slider.current.setAttribute("aria-valuetext", say(value));
    placeThumb(root.current, value, min, max);
    field.current?.setAttribute("aria-valuenow", String(value));
    if (field.current && !isEdited(field.current)) {
      field.current.value = fixed(value, unit.digits);
    }
  });

  const change = (value: number) => {
    const [low, high] = limitsOf(joint);
    onChange(Math.min(high, Math.max(low, value / unit.factor)));
  };
  const limits = t("motion.limits", { from: say(min), to: say(max) });
  const disabled = goal === null && !editable;
  const label = t("motion.commanded", { joint: joint.name });
  return (
    <li class="joint">
      <div class="joint-name">
        <code title={joint.name}>{withoutPrefix(joint.name)}</code>
        {name !== undefined && <span class="muted">{name}</span>}
        <span class="joint-actual" title={t("motion.actual")}>
          <i aria-hidden="true" />
          <span class="visually-hidden">{t("motion.actual")}</span>
          <span ref={actual} data-testid={`joint-actual-${joint.name}`} />
        </span>
      </div>
      <div
        class="joint-controls"
        title={disabled ? limits : `${limits}. ${t("motion.reset")}`}
      >
        <Slider
          label={label}
          valueText={say(shown)}
          min={min}
          max={max}
          value={shown}
          step={unit.step}
          disabled={disabled}
          root={root}
          input={slider}
          onInput={change}
          {...(isReal.value && { onChange: () => void holdStill() })}
          onDoubleClick={() => {
            if (!disabled) onChange(position());
          }}
          data-testid={`joint-slider-${joint.name}`}
        />
        <NumberField
          label={label}
          unit={unit.symbol}
          value={shown}
          digits={unit.digits}
          min={limitsOf(joint)[0] * unit.factor}
          max={limitsOf(joint)[1] * unit.factor}
          step={unit.step}
          disabled={disabled}
          input={field}
          onCommit={change}
          data-testid={`joint-field-${joint.name}`}
        />
      </div>
    </li>
  );
}
