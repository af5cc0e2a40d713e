/** Settings that the browser keeps between visits; nothing depends on them, since it may forbid that. */
import { effect, type Signal, signal } from "@preact/signals";

const PREFIX = "tool0.";

/** Return the stored value, if it is still one of `known`. */
export function recall<T extends string>(
  key: string,
  known: readonly T[],
): T | undefined {
  const found = recallText(key);
  return known.find((value) => value === found);
}

/** Return the stored text, whatever it says. */
export function recallText(key: string): string | undefined {
  try {
    return localStorage.getItem(PREFIX + key) ?? undefined;
  } catch {
    return undefined;
  }
}

/** Return a choice, at first the stored one or `first`, that is stored when it changes. */
export function remembered<T extends string>(
  key: string,
  known: readonly T[],
  first: T,
): Signal<T> {
  const chosen = signal(recall(key, known) ?? first);
  effect(() => {
    remember(key, chosen.value);
  });
  return chosen;
}

/** Return a flag, at first false, that is stored under the words for false and true. */
export function rememberedFlag(
  key: string,
  [no, yes]: readonly [string, string],
): Signal<boolean> {
  const flag = signal(recall(key, [no, yes]) === yes);
  effect(() => {
    remember(key, flag.value ? yes : no);
  });
  return flag;
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(PREFIX + key, value);
  } catch {
    // without storage the page works, too
  }
}
