/** One of few: as a segmented control, or as tabs. Arrow keys move, as ARIA asks. */
import type { Signal } from "@preact/signals";
import type { ComponentChildren } from "preact";

export interface Choice<T extends string> {
  value: T;
  label: ComponentChildren;
  /** For screen readers, where the label is a picture. */
  name?: string;
  testId?: string;
}

interface ChoiceProps<T extends string> {
  label: string;
  value: T;
  choices: readonly Choice<T>[];
  onChange: (value: T) => void;
  "data-testid"?: string;
}

/** Return the place that an arrow key moves to, of `count` in a ring. */
export function movedBy(key: string, at: number, count: number): number | undefined {
  if (key === "ArrowRight" || key === "ArrowDown") return (at + 1) % count;
  if (key === "ArrowLeft" || key === "ArrowUp") return (at + count - 1) % count;
  if (key === "Home") return 0;
  if (key === "End") return count - 1;
  return undefined;
}

function useKeys<T extends string>({ value, choices, onChange }: ChoiceProps<T>) {
  return (event: KeyboardEvent & { currentTarget: HTMLElement }) => {
    const at = choices.findIndex((choice) => choice.value === value);
    const to = movedBy(event.key, at, choices.length);
    const chosen = to === undefined ? undefined : choices[to];
    if (chosen === undefined || to === undefined) return;
    event.preventDefault();
    onChange(chosen.value);
    event.currentTarget.querySelectorAll("button")[to]?.focus();
  };
}

export function Segmented<T extends string>(props: ChoiceProps<T>) {
  const onKeyDown = useKeys(props);
  return (
    <div
      class="segmented"
      role="radiogroup"
      aria-label={props.label}
      data-testid={props["data-testid"]}
      onKeyDown={onKeyDown}
    >
      {props.choices.map((choice) => (
        <button
          key={choice.value}
          type="button"
          role="radio"
          aria-checked={choice.value === props.value}
          aria-label={choice.name}
          title={choice.name}
          tabIndex={choice.value === props.value ? 0 : -1}
          data-testid={choice.testId}
          onClick={() => {
            props.onChange(choice.value);
          }}
        >
          {choice.label}
        </button>
      ))}
    </div>
  );
}

interface SignalChoiceProps<T extends string> {
  label: string;
  of: Signal<T>;
  among: readonly T[];
  name: (value: T) => string;
  /** Each choice has this test id, with its value appended. */
  testId: string;
}

/** Chooses a signal's value. */
export function SignalChoice<T extends string>(props: SignalChoiceProps<T>) {
  const { label, of, among, name, testId } = props;
  return (
    <Segmented
      label={label}
      value={of.value}
      choices={among.map((value) => ({
        value,
        label: name(value),
        testId: `${testId}-${value}`,
      }))}
      onChange={(value) => {
        of.value = value;
      }}
    />
  );
}

/** Tabs; the panel of `value` is to have the id `panel-VALUE`. */
export function Tabs<T extends string>(props: ChoiceProps<T>) {
  const onKeyDown = useKeys(props);
  return (
    <div class="tabs" role="tablist" aria-label={props.label} onKeyDown={onKeyDown}>
      {props.choices.map((choice) => (
        <button
          key={choice.value}
          type="button"
          role="tab"
          id={`tab-${choice.value}`}
          aria-selected={choice.value === props.value}
          aria-controls={`panel-${choice.value}`}
          tabIndex={choice.value === props.value ? 0 : -1}
          data-testid={choice.testId}
          onClick={() => {
            props.onChange(choice.value);
          }}
        >
          {choice.label}
        </button>
      ))}
    </div>
  );
}
