/**
 * A number with its unit.  Enter or leaving the field commits it, arrows step it.  Values outside
 * the limits are rejected, and the field reports it.
 */
import type { RefObject } from "preact";
import { useEffect, useId, useState } from "preact/hooks";
import { t } from "../i18n";
import { parseQuantity } from "../units";
import { stepped } from "./slider";

interface NumberFieldProps {
  label: string;
  /** Before the number, for the eye: `label` says it as well. */
  prefix?: string;
  unit?: string;
  /** Whether the unit follows the number; it does if this is left out. */
  showsUnit?: boolean;
  value: number;
  digits: number;
  min: number;
  max: number;
  step: number;
  disabled?: boolean;
  input?: RefObject<HTMLInputElement | null>;
  onCommit: (value: number) => void;
  "data-testid"?: string;
}

/** Return `value` with so many digits; never "-0.00". */
export function fixed(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

/** Return why `text` is rejected, or undefined if it is a value within the limits. */
function complaint(
  typed: number | undefined,
  props: NumberFieldProps,
): string | undefined {
  const { min, max, digits, unit = "" } = props;
  if (typed === undefined) return t("field.notANumber", { unit });
  // the limits are shown rounded, and may be typed as they are shown
  const rounding = 0.5 * 10 ** -digits;
  if (typed >= min - rounding && typed <= max + rounding) return undefined;
  const [from, to] = [fixed(min, digits), fixed(max, digits)];
  return t("field.outside", { from, to, unit });
}

export function NumberField(props: NumberFieldProps) {
  const { min, max, step, digits, unit = "" } = props;
  const [draft, setDraft] = useState<string | null>(null);
  const id = useId();
  const typed = draft === null ? undefined : parseQuantity(draft, unit);
  const problem = draft === null ? undefined : complaint(typed, props);
  // a rejected input stays for correction, until the value changes by other means
  useEffect(() => {
    setDraft((now) => (document.activeElement?.id === id ? now : null));
  }, [props.value, props.disabled, id]);

  const commit = () => {
    if (problem !== undefined) return;
    setDraft(null);
    if (typed !== undefined) props.onCommit(Math.min(max, Math.max(min, typed)));
  };

  return (
    <span
      class={`field ${props.disabled === true ? "disabled" : ""} ${problem === undefined ? "" : "invalid"}`}
    >
      {props.prefix !== undefined && (
        <span class="prefix" aria-hidden="true">
          {props.prefix}
        </span>
      )}
      <input
        class="number"
        id={id}
        type="text"
        inputMode="decimal"
        role="spinbutton"
        ref={props.input ?? null}
        aria-label={props.label}
        aria-valuemin={Number.isFinite(min) ? min : undefined}
        aria-valuemax={Number.isFinite(max) ? max : undefined}
        aria-valuenow={props.value}
        aria-invalid={problem !== undefined}
        aria-errormessage={`${id}-problem`}
        disabled={props.disabled ?? false}
        value={draft ?? fixed(props.value, digits)}
        data-testid={props["data-testid"]}
        onFocus={(event) => {
          event.currentTarget.select();
        }}
        onInput={(event) => {
          setDraft(event.currentTarget.value);
        }}
        onBlur={commit}
        onKeyDown={(event) => {
          if (event.key === "Enter") commit();
          if (event.key === "Escape") setDraft(null);
          if (!event.key.startsWith("Arrow") || /Left|Right/.test(event.key)) return;
          // the field's own text, since it may follow the robot between two renders
          const text = problem === undefined ? event.currentTarget.value : "";
          const from = parseQuantity(text, unit) ?? props.value;
          const next = stepped(event, { value: from, min, max, step });
          event.preventDefault();
          setDraft(null);
          if (next !== undefined) props.onCommit(next);
        }}
      />
      {props.showsUnit !== false && unit !== "" && <span class="unit">{unit}</span>}
      {problem !== undefined && (
        <span class="field-problem" role="alert" id={`${id}-problem`}>
          {problem}
        </span>
      )}
    </span>
  );
}
