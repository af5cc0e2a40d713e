/**
 * Dragging a slider.  A browser's own slider jumps to the finger that begins to scroll, so
 * here a touch moves the thumb only by as much as it goes sideways; a tap does nothing.
 */
import { useRef } from "preact/hooks";

/** The thumb's size, as in the style sheet [px]. */
const THUMB = 16;
/** How far a touch must go sideways first [px]. */
const SLOP = 8;

interface Dragged {
  min: number;
  max: number;
  disabled?: boolean;
  onInput: (value: number) => void;
  onChange?: (value: number) => void;
}

interface Drag {
  readonly pointer: number;
  /** The value before the drag, to detect a click or a drag back. */
  readonly before: number;
  /** Where the pointer is at `value` [px]. */
  readonly x: number;
  readonly y: number;
  readonly value: number;
  /** Whether it has gone far enough to be no tap. */
  readonly moves: boolean;
}

type Handler = (event: PointerEvent & { currentTarget: HTMLElement }) => void;

export function useDrag({ min, max, disabled, onInput, onChange }: Dragged) {
  const drag = useRef<Drag | null>(null);
  const inputOf = (root: HTMLElement) => root.querySelector("input");
  /** Value per pixel. */
  const scale = (root: HTMLElement) => (max - min) / (root.clientWidth - THUMB);
  const put = (input: HTMLInputElement, value: number) => {
    const wanted = Math.min(max, Math.max(min, value));
    if (wanted === input.valueAsNumber) return;
    input.value = String(wanted);
    onInput(wanted);
  };

  const onPointerDown: Handler = (event) => {
    const root = event.currentTarget;
    const input = inputOf(root);
    if (!input || disabled === true || event.button !== 0 || !event.isPrimary) return;
    event.preventDefault();
    input.focus({ preventScroll: true });
    root.setPointerCapture(event.pointerId);
    const { clientX: x, clientY: y, pointerId: pointer } = event;
    const before = input.valueAsNumber;
    const thumb =
      root.getBoundingClientRect().left + THUMB / 2 + (before - min) / scale(root);
    const isTouch = event.pointerType === "touch";
    if (!isTouch && Math.abs(x - thumb) > THUMB / 2) {
      put(input, before + (x - thumb) * scale(root));
    }
    const value = input.valueAsNumber;
    drag.current = { pointer, before, x, y, value, moves: !isTouch };
  };
  const onPointerMove: Handler = (event) => {
    const now = drag.current;
    const input = inputOf(event.currentTarget);
    if (!input || now?.pointer !== event.pointerId) return;
    const sideways = event.clientX - now.x;
    if (disabled === true) {
      drag.current = null;
    } else if (now.moves) {
      put(input, now.value + sideways * scale(event.currentTarget));
    } else if (Math.abs(sideways) > Math.max(SLOP, Math.abs(event.clientY - now.y))) {
      drag.current = { ...now, x: event.clientX, moves: true };
    }
  };
  const end: Handler = (event) => {
    const now = drag.current;
    if (now?.pointer !== event.pointerId) return;
    drag.current = null;
    const value = inputOf(event.currentTarget)?.valueAsNumber ?? now.before;
    if (value !== now.before) onChange?.(value);
  };
  return { onPointerDown, onPointerMove, onPointerUp: end, onPointerCancel: end };
}
