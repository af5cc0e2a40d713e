/** A number with its unit.  Enter or leaving the field commits it, arrows step it. */
import type { RefObject } from "preact";
import { useState } from "preact/hooks";
import { stepped } from "./slider";

interface NumberFieldProps {
  label: string;
  unit?: string;
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

/** Return what a person typed as a number; a comma is as good as a point. */
export function parseNumber(text: string): number | undefined {
  const cleaned = text.trim().replace("−", "-").replace(",", ".");
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(cleaned)) return undefined;
  return Number(cleaned);
}

/** Return `value` with so many digits; never "-0.00". */
export function fixed(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

export function NumberField(props: NumberFieldProps) {
  const { min, max, step, digits } = props;
  const [draft, setDraft] = useState<string | null>(null);
  const typed = draft === null ? undefined : parseNumber(draft);
  const invalid = draft !== null && typed === undefined;

  const commit = () => {
    setDraft(null);
    if (typed !== undefined) props.onCommit(Math.min(max, Math.max(min, typed)));
  };

  return (
    <span
      class={`field ${props.disabled === true ? "disabled" : ""} ${invalid ? "invalid" : ""}`}
    >
      <input
        class="number"
        type="text"
        inputMode="decimal"
        role="spinbutton"
        ref={props.input ?? null}
        aria-label={props.label}
        aria-valuemin={min}
        aria-valuemax={max}
        aria-valuenow={props.value}
        aria-invalid={invalid}
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
          const from = parseNumber(event.currentTarget.value) ?? props.value;
          const next = stepped(event, { value: from, min, max, step });
          event.preventDefault();
          setDraft(null);
          if (next !== undefined) props.onCommit(next);
        }}
      />
      {props.unit !== undefined && <span class="unit">{props.unit}</span>}
    </span>
  );
}
