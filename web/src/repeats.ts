/** Notices that repeat each other: the log and the time line show them as one. */
import type { Notice } from "./protocol";

/** A busy machine says in turns that it falls behind and keeps up: within this it is one thing [s]. */
const ONE_OVERRUN = 60;

export interface Entry {
  /** The newest. */
  readonly notice: Notice;
  /** How many there are. */
  readonly count: number;
}

/** Whether two notices are of one spell in which the simulation falls behind. */
export function isSameOverrun(later: Notice, earlier: Notice | undefined): boolean {
  return (
    later.code === "overrun" &&
    earlier?.code === "overrun" &&
    later.wall_time - earlier.wall_time < ONE_OVERRUN
  );
}

function isSame(one: Notice, other: Notice | undefined): boolean {
  return (
    one.code === other?.code &&
    one.severity === other.severity &&
    one.text === other.text
  );
}

/** Return the notices in order, with those that repeat each other in one entry. */
export function gathered(notices: readonly Notice[]): readonly Entry[] {
  const entries: Entry[] = [];
  for (const notice of notices) {
    const at = isSame(notice, entries.at(-1)?.notice)
      ? entries.length - 1
      : entries.findIndex((entry) => isSameOverrun(notice, entry.notice));
    const [before] = at < 0 ? [] : entries.splice(at, 1);
    entries.push({ notice, count: (before?.count ?? 0) + 1 });
  }
  return entries;
}
