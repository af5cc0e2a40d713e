import { computed, signal } from "@preact/signals";
import { en } from "./en";
import { zh } from "./zh";

export type Language = "en" | "zh";
export type Key = keyof typeof en;
export type Texts = Record<Key, string>;

const texts: Record<Language, Texts> = { en, zh };

export const language = signal<Language>("en");
const current = computed(() => texts[language.value]);

/** Return a text in the person's language, `{name}` replaced by `values.name`. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  return current.value[key].replace(/\{(\w+)\}/g, (whole, name: string) =>
    String(values[name] ?? whole),
  );
}
