/** Whether the server still sends: it repeats the last frame while nothing changes. */
import { signal } from "@preact/signals";
import { frames } from "./frames";
import { connectionState } from "./store";

export const SILENT_AFTER_MS = 500;
const CHECK_MS = 100;

/** Time since the last frame [s]; null while frames arrive. */
export const silence = signal<number | null>(null);

/** Watch the frames; call the result to end the watch. */
export function watchSilence(): () => void {
  let checked = performance.now();
  const timer = setInterval(() => {
    const now = performance.now();
    // after a long task of this page, frames may still wait to be read
    const wasBusy = now - checked > 2 * CHECK_MS;
    checked = now;
    const newest = frames.last.at(-1)?.arrival ?? now;
    const quiet = connectionState.value === "open" ? now - newest : 0;
    if (quiet <= SILENT_AFTER_MS) silence.value = null;
    else if (!wasBusy) silence.value = quiet / 1000;
  }, CHECK_MS);
  return () => {
    clearInterval(timer);
    silence.value = null;
  };
}
