/** Where a window is, within the scene: moved by pointer or keys, and kept. */
import { recallText, remember } from "../ui/memory";

/** By how much an arrow key moves a window [px]. */
const STEP = 24;
const DIRECTIONS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-STEP, 0],
  ArrowRight: [STEP, 0],
  ArrowUp: [0, -STEP],
  ArrowDown: [0, STEP],
};
/** Gap between windows that nobody has moved yet [px]. */
const GAP = 12;
const TOP = 64;
const LEFT = 12;

interface Place {
  readonly x: number;
  readonly y: number;
  /** Of the window [px]; its height follows from the image. */
  readonly width: number;
}

const key = (name: string) => `camera-place/${name}`;

function stored(name: string): Place | undefined {
  const [x, y, width] = (recallText(key(name)) ?? "").split(" ").map(Number);
  if (x === undefined || y === undefined || width === undefined) return undefined;
  return [x, y, width].every(Number.isFinite) ? { x, y, width } : undefined;
}

/** Put a window where it was; call the result to end watching its size. */
export function keepPlace(root: HTMLElement, name: string, index: number): () => void {
  const usual = { x: LEFT + index * (root.offsetWidth + GAP), y: TOP, width: 0 };
  const { x, y, width } = stored(name) ?? usual;
  if (width > 0) root.style.width = `${String(width)}px`;
  put(root, x, y);
  let isFirst = true;
  const size = new ResizeObserver(() => {
    if (!isFirst) keep(root, name);
    isFirst = false;
  });
  size.observe(root);
  const fit = () => {
    put(root, root.offsetLeft, root.offsetTop);
  };
  window.addEventListener("resize", fit);
  return () => {
    size.disconnect();
    window.removeEventListener("resize", fit);
  };
}

/** Move a window, but not out of the scene. */
function put(root: HTMLElement, x: number, y: number): void {
  const scene = root.parentElement;
  if (!scene) return;
  const most = (all: number, own: number) => Math.max(0, all - Math.min(own, all));
  const left = Math.min(Math.max(0, x), most(scene.clientWidth, root.offsetWidth));
  const top = Math.min(Math.max(0, y), most(scene.clientHeight, root.offsetHeight));
  root.style.left = `${String(left)}px`;
  root.style.top = `${String(top)}px`;
}

function keep(root: HTMLElement, name: string): void {
  remember(key(name), [root.offsetLeft, root.offsetTop, root.offsetWidth].join(" "));
}

/** Let the pointer drag a window. */
export function startMove(root: HTMLElement, name: string, event: PointerEvent): void {
  const isControl = (event.target as Element).closest("button, select") !== null;
  if (event.button !== 0 || isControl) return;
  const header = event.currentTarget as HTMLElement;
  const [dx, dy] = [root.offsetLeft - event.clientX, root.offsetTop - event.clientY];
  header.setPointerCapture(event.pointerId);
  const move = (moved: PointerEvent) => {
    put(root, moved.clientX + dx, moved.clientY + dy);
  };
  header.addEventListener("pointermove", move);
  header.addEventListener(
    "lostpointercapture",
    () => {
      header.removeEventListener("pointermove", move);
      keep(root, name);
    },
    { once: true },
  );
}

/** Move a window by an arrow key, or change its width while Shift is held. */
export function moveByKey(root: HTMLElement, name: string, event: KeyboardEvent): void {
  if (event.target !== event.currentTarget) return;
  const direction = DIRECTIONS[event.key];
  if (direction === undefined) return;
  const [dx, dy] = direction;
  event.preventDefault();
  if (event.shiftKey) root.style.width = `${String(root.offsetWidth + dx + dy)}px`;
  else put(root, root.offsetLeft + dx, root.offsetTop + dy);
  keep(root, name);
}
