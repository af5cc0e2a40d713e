/** Dragging a step by its grip to another place: with a mouse, a pen or a finger. */
import { signal } from "@preact/signals";
import type { RefObject } from "preact";
import { useRef } from "preact/hooks";
import { t } from "../../i18n";
import { move, steps } from "../../program/editor";
import { isLoop, next, type Path, pathText, stepAt } from "../../program/steps";

type Where = "before" | "after" | "into";

/** Where the dragged step would go: on which row, and on which side of it. */
export const drop = signal<{ row: string; where: Where } | null>(null);
/** The same for screen readers. */
export const dropText = signal("");

interface Drag {
  readonly from: Path;
  readonly pointer: number;
}

type Handler = (event: PointerEvent & { currentTarget: HTMLElement }) => void;

function pathOf(row: Element): Path {
  return (row.getAttribute("data-path") ?? "").split(".").map(Number);
}

/** Return which side of a row a height in the window is on [px]. */
export function sideOf(box: { top: number; height: number }, y: number, loop: boolean) {
  const part = (y - box.top) / box.height;
  if (loop && part > 0.3) return "into";
  return part < 0.5 ? "before" : "after";
}

/** Return the place in the list that a drop means. */
export function placeOfDrop(path: Path, where: Where): Path {
  if (where === "before") return path;
  return where === "into" ? [...path, 1] : next(path);
}

export function useReorder(list: RefObject<HTMLElement | null>) {
  const drag = useRef<Drag | null>(null);
  const onPointerDown: Handler = (event) => {
    const target = event.target as Element;
    const row = target.closest("[data-path]");
    if (event.button !== 0 || !target.closest(".grip") || !row) return;
    event.preventDefault();
    event.currentTarget.setPointerCapture(event.pointerId);
    drag.current = { from: pathOf(row), pointer: event.pointerId };
  };
  const onPointerMove: Handler = (event) => {
    if (drag.current?.pointer !== event.pointerId) return;
    const under = [...(list.current?.querySelectorAll("[data-path]") ?? [])].find(
      (row) => event.clientY < row.getBoundingClientRect().bottom,
    );
    if (!under) return;
    const path = pathOf(under);
    const loop = isLoop(stepAt(steps.peek(), path));
    const where = sideOf(under.getBoundingClientRect(), event.clientY, loop);
    drop.value = { row: pathText(path), where };
  };
  const end = (event: PointerEvent, isDropped: boolean) => {
    const now = drag.current;
    if (now?.pointer !== event.pointerId) return;
    const target = drop.peek();
    drag.current = drop.value = null;
    if (!isDropped || target === null) return;
    const to = placeOfDrop(target.row.split(".").map(Number), target.where);
    if (move(now.from, to)) {
      dropText.value = t("program.moved", { from: pathText(now.from) });
    }
  };
  const onPointerUp: Handler = (event) => {
    end(event, true);
  };
  const onPointerCancel: Handler = (event) => {
    end(event, false);
  };
  return { onPointerDown, onPointerMove, onPointerUp, onPointerCancel };
}
