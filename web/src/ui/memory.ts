/** What this browser remembers between visits; it may have forbidden it, so nothing depends on it. */
const PREFIX = "tool0.";

/** Return what was remembered, if it is still one of `known`. */
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
    // a browser that keeps nothing still shows everything
  }
}
