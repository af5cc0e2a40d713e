/** What the pointer does over the picture: a name, a glow, a click, a double click. */
import { selectRobot } from "../driving";
import { language } from "../i18n";
import { model } from "../model";
import { place, placing } from "../placing";
import { robotOfLink } from "../robots";
import { select, type Selection } from "../selection";
import { view, hoveredLink } from "../store";
import type { Hit } from "./picker";
import type { Viewer } from "./viewer";

/** Farther than this a pressed pointer turns the view and is no click [px]. */
const CLICK = 4;

/** The display name of the object under the pointer. */
function nameOf(hit: Hit): string {
  const link = hit.link ?? "";
  const part = view.value?.robot.part_names[link]?.[language.value];
  return hit.object ?? (part === undefined ? link : `${part} · ${link}`);
}

function selectionOf(hit: Hit | undefined): Selection | null {
  if (hit?.object !== undefined) return { kind: "object", name: hit.object };
  return hit?.link === undefined ? null : { kind: "link", name: hit.link };
}

/** Watch the pointer; the answer ends it. */
export function watchPointer(
  host: HTMLElement,
  canvas: HTMLCanvasElement,
  viewer: Viewer,
): () => void {
  const tip = host.appendChild(document.createElement("div"));
  tip.className = "scene-tip";
  tip.hidden = true;
  let due = 0;
  let set: string | null = null;

  const hover = (link: string | null) => {
    // do not clear what the tree has set since
    if (link === null && hoveredLink.peek() !== set) return;
    set = link;
    hoveredLink.value = link;
  };
  const leave = () => {
    cancelAnimationFrame(due);
    due = 0;
    tip.hidden = true;
    hover(null);
  };
  const look = (x: number, y: number) => {
    due = 0;
    if (placing.peek() && !viewer.isDragging) viewer.aimPlace(x, y);
    const hit = viewer.isDragging ? undefined : viewer.at(x, y);
    tip.hidden = hit === undefined;
    hover(hit?.link ?? null);
    if (!hit) return;
    const { left, top, width } = host.getBoundingClientRect();
    tip.textContent = nameOf(hit);
    const right = x - left > width / 2;
    const across = right ? `calc(${x - left - 12}px - 100%)` : `${x - left + 16}px`;
    tip.style.transform = `translate(${across}, ${y - top + 12}px)`;
  };
  const move = (event: PointerEvent) => {
    if (event.pointerType === "touch") return;
    const { clientX, clientY } = event;
    cancelAnimationFrame(due);
    due = requestAnimationFrame(() => {
      look(clientX, clientY);
    });
  };
  let pressed = { x: NaN, y: NaN };
  const press = (event: PointerEvent) => {
    pressed = { x: event.clientX, y: event.clientY };
    leave();
  };
  const click = ({ clientX, clientY, shiftKey }: MouseEvent) => {
    if (Math.hypot(clientX - pressed.x, clientY - pressed.y) > CLICK) return;
    if (placing.peek()) {
      const to = viewer.aimPlace(clientX, clientY);
      if (to) void place([to.x, to.y, to.z], shiftKey);
      return;
    }
    // a click on its handles selects nothing else
    if (viewer.isOnHandles) return;
    const hit = viewer.at(clientX, clientY);
    select(selectionOf(hit));
    const robot = hit?.link && robotOfLink(model.peek(), hit.link);
    if (robot) selectRobot(robot.name);
  };
  const focus = (event: MouseEvent) => {
    const hit = viewer.at(event.clientX, event.clientY);
    if (hit) viewer.focus(hit.point);
  };
  canvas.addEventListener("pointermove", move);
  canvas.addEventListener("pointerdown", press);
  canvas.addEventListener("click", click);
  canvas.addEventListener("pointerleave", leave);
  canvas.addEventListener("dblclick", focus);
  return leave;
}
