/**
 * Keyboard shortcuts of the whole page: each is registered with its description, so that
 * the help lists what exists.  Fields that take text keep their keys.
 */
import { signal } from "@preact/signals";
import type { Key } from "./i18n";

/** A heading of the help. */
export type ShortcutGroup = "general" | "scene" | "jog" | "program" | "timeline";

export interface Shortcut {
  /** As `KeyboardEvent.key`, with `Ctrl+` or `Shift+` before it: `?`, `Ctrl+z`. */
  readonly keys: readonly string[];
  readonly text: Key;
  readonly group: ShortcutGroup;
  /** What the keys do anywhere on the page; without it they are only listed. */
  readonly run?: (event: KeyboardEvent) => void;
  /** Whether `run` applies now. */
  readonly when?: () => boolean;
}

export const shortcuts = signal<readonly Shortcut[]>([]);

/** Add shortcuts; call the result to remove them. */
export function register(...added: readonly Shortcut[]): () => void {
  shortcuts.value = [...shortcuts.peek(), ...added];
  return () => {
    shortcuts.value = shortcuts.peek().filter((one) => !added.includes(one));
  };
}

/** Return the name of the pressed key, as `Shortcut.keys` has it. */
export function keyName(event: KeyboardEvent): string {
  const isLetter = /^[a-z]$/i.test(event.key);
  const key = isLetter ? event.key.toLowerCase() : event.key;
  const named = event.key.length > 1 || isLetter;
  const shift = event.shiftKey && named ? "Shift+" : "";
  return `${event.ctrlKey || event.metaKey ? "Ctrl+" : ""}${shift}${key}`;
}

/** Whether the pressed key belongs to a field that the user types into. */
export function isTyping(event: KeyboardEvent): boolean {
  const { target } = event;
  if (!(target instanceof HTMLElement)) return false;
  if (target.isContentEditable) return true;
  return target.matches("input:not([type=range], [type=checkbox]), textarea, select");
}

/** Execute the shortcut of a pressed key. */
export function onShortcut(event: KeyboardEvent): void {
  if (event.defaultPrevented || event.altKey || event.isComposing || isTyping(event)) {
    return;
  }
  const name = keyName(event);
  const found = shortcuts
    .peek()
    .find(({ keys, run, when }) => run && keys.includes(name) && (when?.() ?? true));
  if (found === undefined) return;
  event.preventDefault();
  found.run?.(event);
}
