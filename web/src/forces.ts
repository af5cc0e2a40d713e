/** Forces cost the robot something, so frames have them only while a part of the page needs them. */
import { computed, signal } from "@preact/signals";

export interface Forces {
  /** `frame.contacts` */
  readonly contacts: boolean;
  /** `frame.wrenches` */
  readonly wrenches: boolean;
}

const contactUsers = signal(0);
const wrenchUsers = signal(0);
const contacts = computed(() => contactUsers.value > 0);
const wrenches = computed(() => wrenchUsers.value > 0);

/** What the page needs now; connection.ts requests it. */
export const neededForces = computed<Forces>(() => ({
  contacts: contacts.value,
  wrenches: wrenches.value,
}));

/** Let the frames have contacts or wrenches until the result is called. */
export function need(wanted: Partial<Forces>): () => void {
  const users = [
    ...(wanted.contacts ? [contactUsers] : []),
    ...(wanted.wrenches ? [wrenchUsers] : []),
  ];
  for (const count of users) count.value = count.peek() + 1;
  let isReleased = false;
  return () => {
    if (isReleased) return;
    isReleased = true;
    for (const count of users) count.value = count.peek() - 1;
  };
}
