/** Settings that the browser keeps between visits; nothing depends on them, since it may forbid that. */
const PREFIX = "tool0.";

/** Return the stored value, if it is still one of `known`. */
export function recall<T extends string>(
  key: string,
  known: readonly T[],
): T | undefined {
  try {
    const found = localStorage.getItem(PREFIX + key);
    return known.find((value) => value === found);
  } catch {
    return undefined;
  }
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(PREFIX + key, value);
  } catch {
    // without storage the page works, too
  }
}
