import { computed, effect, signal } from "@preact/signals";
import { recall, remember } from "../ui/memory";
import { en } from "./en";
import { zh } from "./zh";

export type Language = "en" | "zh";
export type Key = keyof typeof en;
export type Texts = Record<Key, string>;

const texts: Record<Language, Texts> = { en, zh };

function preferred(): Language {
  return navigator.language.toLowerCase().startsWith("zh") ? "zh" : "en";
}

export const language = signal<Language>(
  recall("language", ["en", "zh"]) ?? preferred(),
);
const current = computed(() => texts[language.value]);

effect(() => {
  document.documentElement.lang = language.value === "zh" ? "zh-CN" : "en";
});

/** Choose a language for this visit and the next. */
export function speak(chosen: Language): void {
  language.value = chosen;
  remember("language", chosen);
}

const PLACEHOLDER = /\{(\w+)(?:\|([^|}]*)\|([^|}]*))?\}/g;

/**
 * Return a text in the user's language: `{name}` becomes `values.name`, and
 * `{name|page|pages}` the word for so many.
 */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  return current.value[key].replace(
    PLACEHOLDER,
    (whole, name: string, one?: string, many?: string) => {
      const value = values[name];
      if (value === undefined) return whole;
      if (many === undefined) return String(value);
      return String(value === 1 ? one : many);
    },
  );
}
