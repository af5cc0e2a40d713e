/** A slider: the thumb is the commanded value; a marker may show the actual one. */
import type { RefObject } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { useDrag } from "./drag";

interface SliderProps {
  label: string;
  /** The value with its unit, for screen readers. */
  valueText: string;
  min: number;
  max: number;
  value: number;
  /** Step of an arrow key; ten times as much with Shift or Page Up. */
  step: number;
  disabled?: boolean;
  /** Given, there is a marker; its style's `--actual-at`, 0 to 1, says where. */
  root?: RefObject<HTMLDivElement | null>;
  input?: RefObject<HTMLInputElement | null>;
  onInput: (value: number) => void;
  /** Called when the user is done: at the end of a drag, and after each key. */
  onChange?: (value: number) => void;
  onDoubleClick?: () => void;
  "data-testid"?: string;
}

/** Return where `value` is between `min` and `max`, from 0 to 1. */
export function share(value: number, min: number, max: number): number {
  return max > min ? Math.min(1, Math.max(0, (value - min) / (max - min))) : 0;
}

/** Fill the track between zero, or the end next to it, and `value`. */
export function placeThumb(
  root: HTMLElement | null,
  value: number,
  min: number,
  max: number,
): void {
  const at = share(value, min, max);
  const zero = share(0, min, max);
  root?.style.setProperty("--low", String(Math.min(at, zero)));
  root?.style.setProperty("--high", String(Math.max(at, zero)));
}

/** Return the value after a key, or undefined for a key that sliders do not have. */
export function stepped(
  event: Pick<KeyboardEvent, "key" | "shiftKey">,
  { value, min, max, step }: { value: number; min: number; max: number; step: number },
): number | undefined {
  const one = event.shiftKey ? 10 * step : step;
  const by: Record<string, number> = {
    ArrowUp: one,
    ArrowRight: one,
    ArrowDown: -one,
    ArrowLeft: -one,
    PageUp: 10 * step,
    PageDown: -10 * step,
    Home: min - value,
    End: max - value,
  };
  const change = by[event.key];
  if (change === undefined) return undefined;
  return Math.min(max, Math.max(min, value + change));
}

export function Slider(props: SliderProps) {
  const { min, max, value, step } = props;
  const own = useRef<HTMLDivElement | null>(null);
  const root = props.root ?? own;
  // always, since followers of the robot also write it, without Preact
  useLayoutEffect(() => {
    placeThumb(root.current, value, min, max);
  });
  const drag = useDrag(props);
  return (
    <div class="slider" ref={root} onDblClick={() => props.onDoubleClick?.()} {...drag}>
      <input
        type="range"
        ref={props.input ?? null}
        min={min}
        max={max}
        step="any"
        value={value}
        disabled={props.disabled ?? false}
        aria-label={props.label}
        aria-valuetext={props.valueText}
        data-testid={props["data-testid"]}
        onInput={(event) => {
          props.onInput(event.currentTarget.valueAsNumber);
        }}
        onChange={(event) => {
          props.onChange?.(event.currentTarget.valueAsNumber);
        }}
        onKeyDown={(event) => {
          // the input's own value, since it may follow the robot between two renders
          const from = event.currentTarget.valueAsNumber;
          const next = stepped(event, { value: from, min, max, step });
          if (next === undefined) return;
          event.preventDefault();
          if (next === from) return;
          props.onInput(next);
          props.onChange?.(next);
        }}
      />
      {props.root && <span class="actual" />}
    </div>
  );
}
