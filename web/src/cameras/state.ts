/** Which cameras are shown, and how; the browser keeps it. */
import { computed, signal } from "@preact/signals";
import type { CameraInfo } from "../protocol";
import { view } from "../store";
import { recallText, remember } from "../ui/memory";

export type ImageKind = "color" | "depth";

/** Widths of images to choose from [px]. */
export const WIDTHS = [320, 480, 640, 1280] as const;

/** How one camera is shown. */
export interface Setting {
  readonly isOpen: boolean;
  readonly kind: ImageKind;
  /** Of its images [px]. */
  readonly width: number;
}

const USUAL: Setting = { isOpen: false, kind: "color", width: 480 };
const KEY = "cameras";

/** Camera → how it is shown. */
const settings = signal<Readonly<Record<string, Setting>>>(stored(recallText(KEY)));

/** Return what `text` says; cameras of which it says nothing sensible are left out. */
export function stored(text: string | undefined): Record<string, Setting> {
  let found: unknown;
  try {
    found = JSON.parse(text ?? "{}");
  } catch {
    return {};
  }
  if (typeof found !== "object" || found === null) return {};
  const entries = Object.entries(found).filter((entry): entry is [string, Setting] =>
    isSetting(entry[1]),
  );
  return Object.fromEntries(entries);
}

function isSetting(one: unknown): one is Setting {
  if (typeof one !== "object" || one === null) return false;
  const { isOpen, kind, width } = one as Partial<Record<keyof Setting, unknown>>;
  return (
    typeof isOpen === "boolean" &&
    (kind === "color" || kind === "depth") &&
    WIDTHS.some((known) => known === width)
  );
}

export function settingOf(name: string): Setting {
  return settings.value[name] ?? USUAL;
}

export function change(name: string, changes: Partial<Setting>): void {
  const next = { ...settingOf(name), ...changes };
  settings.value = { ...settings.value, [name]: next };
  remember(KEY, JSON.stringify(settings.value));
}

export const cameras = computed<readonly CameraInfo[]>(() => view.value?.cameras ?? []);
export const openCameras = computed(() =>
  cameras.value.filter(({ name }) => settingOf(name).isOpen),
);
