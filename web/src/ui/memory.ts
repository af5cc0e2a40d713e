/** Settings that the browser keeps between visits; nothing depends on them, since it may forbid that. */
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

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(PREFIX + key, value);
  } catch {
    // without storage the page works, too
  }
}
