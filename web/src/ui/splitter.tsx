/** A bar that resizes the part beside it, by pointer or arrow keys; the size is kept. */
import { useEffect, useRef } from "preact/hooks";
import { remember } from "./memory";

interface SplitterProps {
  label: string;
  /** Name of the CSS variable with the size, and of what is remembered. */
  name: string;
  /** Which side of the bar grows when it is dragged towards the other side. */
  grows: "right" | "below";
  /** [px] */
  min: number;
  /** The largest size now [px]. */
  max: () => number;
  /** Size without a choice of the user [px]. */
  initial: number;
}

/** By how much an arrow key moves the bar [px]. */
const STEP = 24;

function stored(name: string): number | undefined {
  try {
    const value = Number(localStorage.getItem(`tool0.${name}`));
    return value > 0 ? value : undefined;
  } catch {
    return undefined;
  }
}

export function Splitter(props: SplitterProps) {
  const { label, name, grows, min, max, initial } = props;
  const bar = useRef<HTMLDivElement | null>(null);
  const size = useRef(stored(name) ?? initial);

  const set = (wanted: number) => {
    const value = Math.round(Math.max(min, Math.min(max(), wanted)));
    size.current = value;
    document.documentElement.style.setProperty(`--${name}`, `${String(value)}px`);
    bar.current?.setAttribute("aria-valuenow", String(value));
    bar.current?.setAttribute("aria-valuemax", String(Math.round(max())));
  };
  const keep = () => {
    remember(name, String(size.current));
  };
  useEffect(() => {
    set(size.current);
    const fit = () => {
      set(size.current);
    };
    window.addEventListener("resize", fit);
    return () => {
      window.removeEventListener("resize", fit);
      document.documentElement.style.removeProperty(`--${name}`);
    };
  }, []);

  const start = (event: PointerEvent) => {
    if (event.button !== 0) return;
    event.preventDefault();
    const from = grows === "right" ? event.clientX : event.clientY;
    const before = size.current;
    const target = event.currentTarget as HTMLElement;
    target.setPointerCapture(event.pointerId);
    const move = (moved: PointerEvent) => {
      set(before + from - (grows === "right" ? moved.clientX : moved.clientY));
    };
    const end = () => {
      target.removeEventListener("pointermove", move);
      keep();
    };
    target.addEventListener("pointermove", move);
    target.addEventListener("lostpointercapture", end, { once: true });
  };
  const onKey = (event: KeyboardEvent) => {
    const [more, less] =
      grows === "right" ? ["ArrowLeft", "ArrowRight"] : ["ArrowUp", "ArrowDown"];
    const change = { [more]: STEP, [less]: -STEP }[event.key];
    if (change === undefined) return;
    event.preventDefault();
    set(size.current + change);
    keep();
  };
  return (
    <div
      ref={bar}
      class={`splitter ${grows}`}
      role="separator"
      tabIndex={0}
      aria-label={label}
      aria-orientation={grows === "right" ? "vertical" : "horizontal"}
      aria-valuemin={min}
      aria-valuenow={size.current}
      data-testid={`splitter-${name}`}
      onPointerDown={start}
      onKeyDown={onKey}
      onDblClick={() => {
        set(initial);
        keep();
      }}
    />
  );
}
