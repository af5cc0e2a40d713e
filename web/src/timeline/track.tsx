/** The line itself: a slider by mouse, touch and keys, with a mark where something happened. */
import { useLayoutEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { useLive } from "../live";
import { share } from "../ui/slider";
import { merged } from "./markers";
import type { Player } from "./player";

/** Step of an arrow key [s]; ten times as much with Shift or Page Up. */
const STEP = 0.1;

/** @param renewed counts up when the ends of the line may have moved */
export function Track({ now, renewed }: { now: Player; renewed: number }) {
  const root = useRef<HTMLDivElement>(null);
  const input = useRef<HTMLInputElement>(null);
  const { start, end } = now.range();

  const follow = () => {
    if (!root.current || !input.current) return;
    const at = now.position();
    root.current.style.setProperty("--at", String(share(at, start, end)));
    input.current.value = String(at);
    input.current.setAttribute("aria-valuetext", `${at.toFixed(2)} s`);
  };
  useLayoutEffect(follow);
  useLive(follow);

  return (
    <div class="timeline-track" ref={root} data-renewed={renewed}>
      <span class="timeline-line" />
      <input
        type="range"
        ref={input}
        min={start}
        max={Math.max(end, start + 1e-3)}
        step="any"
        aria-label={t("timeline.position")}
        data-testid="timeline-position"
        onInput={(event) => {
          const { valueAsNumber: at, max } = event.currentTarget;
          // the line may have grown since it was drawn: its end is the newest
          now.seek(at >= Number(max) ? Infinity : at);
        }}
        onKeyDown={(event) => {
          const by = stepOf(event);
          if (by === undefined) return;
          event.preventDefault();
          now.seek(now.position() + by);
        }}
      />
      {merged(now.markers.value, start, end).map((marker) => (
        <button
          key={marker.at}
          type="button"
          // the keys [ and ] go from one to the next
          tabIndex={-1}
          class={`timeline-marker ${marker.kind}`}
          style={{ "--at": share(marker.at, start, end) }}
          title={`${marker.at.toFixed(2)} s\n${marker.text}`}
          aria-label={`${marker.at.toFixed(2)} s: ${marker.text}`}
          data-testid="timeline-marker"
          data-kind={marker.kind}
          onClick={() => {
            now.seek(marker.at);
          }}
        />
      ))}
    </div>
  );
}

/** Return by how much a key moves [s]; undefined for other keys. */
function stepOf({ key, shiftKey }: KeyboardEvent): number | undefined {
  const one = shiftKey ? 10 * STEP : STEP;
  const by: Record<string, number> = {
    ArrowUp: one,
    ArrowRight: one,
    ArrowDown: -one,
    ArrowLeft: -one,
    PageUp: 10 * STEP,
    PageDown: -10 * STEP,
    Home: -Infinity,
    End: Infinity,
  };
  return by[key];
}
