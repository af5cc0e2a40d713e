/** The visible times, common to all panes, and the cursors. */
import { computed, signal } from "@preact/signals";
import { seconds } from "./layout";
import { type SignalSource, source } from "./signals";

/** A range that the user chose: the samples stay as they were then. */
interface Held {
  readonly source: SignalSource;
  readonly from: number;
  readonly to: number;
}

/** Shortest visible range [s]. */
const SHORTEST = 0.02;

/** Null: the plots follow the robot. */
export const held = signal<Held | null>(null);
/** What the plots read from now. */
export const shownSource = computed(() => held.value?.source ?? source.value);

/** Return the visible range now, from and to [s]. */
export function visible(): [number, number] {
  const { value } = held;
  if (value !== null) return [value.from, value.to];
  // there is no time before zero
  const end = Math.max(shownSource.peek().now(), seconds.value);
  return [end - seconds.value, end];
}

/** Hold the plots at a range of time [s]. */
export function hold([from, to]: readonly [number, number]): void {
  const width = Math.max(SHORTEST, to - from);
  const middle = (from + to) / 2;
  held.value = {
    source: held.peek()?.source ?? source.peek().held(),
    from: middle - width / 2,
    to: middle + width / 2,
  };
}

/** Follow the robot again. */
export function follow(): void {
  held.value = null;
}

/** Move the range by a part of its width. */
export function pan(part: number): void {
  const [from, to] = visible();
  hold([from + part * (to - from), to + part * (to - from)]);
}

/** Make the range `factor` times as wide, with `time` where it is [s]. */
export function zoom(factor: number, time: number): void {
  const [from, to] = visible();
  if (factor < 1 && (to - from) * factor < SHORTEST) return;
  const [first, last] = shownSource.peek().span() ?? [from, to];
  // a wheel that turns on does not leave the samples behind
  if (factor > 1 && to - from > 2 * (last - first) + seconds.peek()) return;
  hold([time - factor * (time - from), time + factor * (to - time)]);
}

/** Show everything that there is. */
export function showAll(): void {
  const span = shownSource.peek().span();
  if (span !== null) hold(span);
}

/** Times of the placed cursors [s]: none, one or two. */
export const cursors = signal<readonly number[]>([]);

/** Place the first or second cursor, or remove both and begin again. */
export function placeCursor(time: number): void {
  cursors.value = cursors.value.length < 2 ? [...cursors.value, time] : [time];
}

/** Move the cursor that was placed last, by a part of the visible range. */
export function moveCursor(part: number): void {
  const [from, to] = visible();
  const last = cursors.value.at(-1);
  if (last === undefined) placeCursor((from + to) / 2);
  else cursors.value = [...cursors.value.slice(0, -1), last + part * (to - from)];
}

export function removeCursors(): void {
  cursors.value = [];
}
