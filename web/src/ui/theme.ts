/** Light or dark: as the system has it, until a person says otherwise. */
import { computed, effect, signal } from "@preact/signals";
import { recall, remember } from "./memory";

export type Theme = "system" | "light" | "dark";

const THEMES: readonly Theme[] = ["system", "light", "dark"];
const dark = window.matchMedia("(prefers-color-scheme: dark)");
const systemIsDark = signal(dark.matches);
dark.addEventListener("change", (event) => {
  systemIsDark.value = event.matches;
});

/** What this person chose. */
export const theme = signal<Theme>(recall("theme", THEMES) ?? "system");
/** What is shown.  Who draws on a canvas redraws, with the tokens' new values, when it changes. */
export const shownTheme = computed<"light" | "dark">(() => {
  if (theme.value !== "system") return theme.value;
  return systemIsDark.value ? "dark" : "light";
});

effect(() => {
  document.documentElement.dataset.theme = shownTheme.value;
});
effect(() => {
  remember("theme", theme.value);
});

/** Return the value of a design token now, such as `token("--accent")`. */
export function token(name: `--${string}`): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
