/** The time line of this page: that of a recording, or of the last minutes. */
import { computed, effect } from "@preact/signals";
import { view } from "../store";
import { neighbour } from "./markers";
import { Past } from "./past";
import type { Player } from "./player";
import { Replay } from "./replay";

export const past = new Past();
const replay = new Replay();

export const player = computed<Player>(() =>
  view.value?.mode === "replay" ? replay : past,
);

effect(() => {
  // the plots of a recording; a running robot needs no such source
  if (view.value?.mode === "replay") void import("./signals");
});

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10] as const;

/** Go to the next mark (+1), or the one before (−1); return whether there is one. */
export function jump(direction: 1 | -1): boolean {
  const now = player.peek();
  const { start, end } = now.range();
  const reachable = now.markers.peek().filter(({ at }) => at >= start && at <= end);
  const next = neighbour(reachable, now.position(), direction);
  if (next) now.seek(next.at);
  return next !== undefined;
}
