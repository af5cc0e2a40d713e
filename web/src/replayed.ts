/** The log of a recording: at the time that is shown, the rest has not happened yet. */
import { computed, signal } from "@preact/signals";
import { shown } from "./frames";
import type { Notice } from "./protocol";
import { notices, view } from "./store";

/** The time shown, updated when another notice has passed [s]. */
const time = signal(Infinity);

function until(end: number): readonly Notice[] {
  return notices.peek().filter((notice) => (notice.time ?? -Infinity) <= end);
}

shown.listen((frame) => {
  if (view.peek()?.mode !== "replay") return;
  if (until(frame.time).length !== until(time.peek()).length) time.value = frame.time;
});

/** The notices up to the time that the page shows. */
export const passedNotices = computed<readonly Notice[]>(() =>
  view.value?.mode === "replay"
    ? notices.value.filter((notice) => (notice.time ?? -Infinity) <= time.value)
    : notices.value,
);
