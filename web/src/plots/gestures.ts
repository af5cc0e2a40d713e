/** Zooming, panning and cursors of a plot: by wheel, pointer, touch and keys. */
import {
  follow,
  hold,
  moveCursor,
  pan,
  placeCursor,
  removeCursors,
  showAll,
  visible,
  zoom,
} from "./range";

/** Movement up to which a press is a click [px]. */
const CLICK = 4;
const KEY_ZOOM = 1.4;
const KEY_PAN = 0.1;

/** How much one step of the wheel zooms. */
function wheelFactor({ deltaY, deltaMode }: WheelEvent): number {
  const pixels = deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 * deltaY : deltaY;
  return Math.exp(Math.max(-200, Math.min(200, pixels)) / 500);
}

/**
 * Let the user move the time axis of the plot whose drawing area is `area`; call the result to
 * end it.
 */
export function handleGestures(area: HTMLElement): () => void {
  const pointers = new Map<number, { x: number; y: number }>();
  let travelled = 0;

  const width = () => Math.max(1, area.clientWidth);
  const timeAt = (clientX: number) => {
    const [from, to] = visible();
    const part = (clientX - area.getBoundingClientRect().left) / width();
    return from + part * (to - from);
  };
  const extent = () => {
    const xs = [...pointers.values()].map(({ x }) => x);
    return { middle: (Math.min(...xs) + Math.max(...xs)) / 2, spread: spreadOf(xs) };
  };

  const onWheel = (event: WheelEvent) => {
    event.preventDefault();
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      pan((event.deltaX || event.deltaY) / width());
    } else zoom(wheelFactor(event), timeAt(event.clientX));
  };
  const onDown = (event: PointerEvent) => {
    if (event.button !== 0) return;
    if (pointers.size === 0) travelled = 0;
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    area.setPointerCapture(event.pointerId);
  };
  const onMove = (event: PointerEvent) => {
    const before = pointers.get(event.pointerId);
    if (before === undefined) return;
    const old = extent();
    travelled += Math.hypot(event.clientX - before.x, event.clientY - before.y);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (travelled <= CLICK) return;
    const now = extent();
    const time = timeAt(old.middle);
    const factor = pointers.size > 1 ? old.spread / now.spread : 1;
    const [from, to] = visible();
    const shift = (factor * (to - from) * (now.middle - old.middle)) / width();
    hold([time - factor * (time - from) - shift, time + factor * (to - time) - shift]);
  };
  const onUp = (event: PointerEvent) => {
    if (!pointers.delete(event.pointerId)) return;
    if (pointers.size > 0)
      travelled = Infinity; // the end of a pinch is no click
    else if (travelled <= CLICK && event.type === "pointerup") {
      placeCursor(timeAt(event.clientX));
    }
  };
  const onDouble = () => {
    removeCursors();
    follow();
  };

  area.addEventListener("wheel", onWheel, { passive: false });
  area.addEventListener("pointerdown", onDown);
  area.addEventListener("pointermove", onMove);
  area.addEventListener("pointerup", onUp);
  area.addEventListener("pointercancel", onUp);
  area.addEventListener("dblclick", onDouble);
  return () => {
    area.removeEventListener("wheel", onWheel);
    area.removeEventListener("pointerdown", onDown);
    area.removeEventListener("pointermove", onMove);
    area.removeEventListener("pointerup", onUp);
    area.removeEventListener("pointercancel", onUp);
    area.removeEventListener("dblclick", onDouble);
  };
}

function spreadOf(xs: readonly number[]): number {
  return Math.max(20, Math.max(...xs) - Math.min(...xs));
}

/** Do what a key means on a focused plot; return whether it means anything. */
function pressed({ key, shiftKey }: KeyboardEvent): boolean {
  const middle = (visible()[0] + visible()[1]) / 2;
  const actions: Record<string, () => void> = {
    ArrowLeft: () => {
      if (shiftKey) moveCursor(-KEY_PAN / 20);
      else pan(-KEY_PAN);
    },
    ArrowRight: () => {
      if (shiftKey) moveCursor(KEY_PAN / 20);
      else pan(KEY_PAN);
    },
    "+": () => {
      zoom(1 / KEY_ZOOM, middle);
    },
    "-": () => {
      zoom(KEY_ZOOM, middle);
    },
    Enter: () => {
      placeCursor(middle);
    },
    Delete: removeCursors,
    Home: showAll,
    End: follow,
  };
  actions[key]?.();
  return key in actions;
}

export function onPlotKey(event: KeyboardEvent): void {
  if (event.ctrlKey || event.metaKey || event.altKey || !pressed(event)) return;
  event.preventDefault();
  event.stopPropagation();
}
