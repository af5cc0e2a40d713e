/** Light or dark: the system's setting, until the user chooses. */
import { computed, effect, signal } from "@preact/signals";
import { remembered } from "./memory";

export type Theme = "system" | "light" | "dark";

const THEMES: readonly Theme[] = ["system", "light", "dark"];
const dark = window.matchMedia("(prefers-color-scheme: dark)");
const systemIsDark = signal(dark.matches);
dark.addEventListener("change", (event) => {
  systemIsDark.value = event.matches;
});

/** The user's choice. */
export const theme = remembered("theme", THEMES, "system");
/** The current theme.  Canvases are redrawn with the tokens' new values when it changes. */
export const shownTheme = computed<"light" | "dark">(() => {
  if (theme.value !== "system") return theme.value;
  return systemIsDark.value ? "dark" : "light";
});

effect(() => {
  document.documentElement.dataset.theme = shownTheme.value;
});

/** Return the value of a design token now, such as `token("--accent")`. */
export function token(name: `--${string}`): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
