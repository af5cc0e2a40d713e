/** Notices: all of them in the log, the important ones as toasts. */
import { signal } from "@preact/signals";
import { t } from "./i18n";
import type { Notice } from "./protocol";
import { notices, view } from "./store";

export type Severity = Notice["severity"];

const KEEP = 2_000;
const SHOW = 4;
const SHOWN_FOR_MS: Record<Severity, number> = {
  info: 4_000,
  warning: 9_000,
  error: Infinity,
};

export interface Toast {
  readonly key: number;
  readonly severity: Severity;
  readonly text: string;
  /** Number of repetitions. */
  readonly count: number;
  /** What the user can do about it; it stays until it is dismissed. */
  readonly actions: readonly Action[];
}

export interface Action {
  readonly name: string;
  readonly label: string;
  readonly run: () => void;
}

export const toasts = signal<readonly Toast[]>([]);

let nextKey = 1;
const timers = new Map<number, ReturnType<typeof setTimeout>>();

export function dismiss(key: number): void {
  clearTimeout(timers.get(key));
  timers.delete(key);
  toasts.value = toasts.value.filter((toast) => toast.key !== key);
}

/** Return the text without its numbers: a slider's refusals differ in nothing else. */
function kind(text: string): string {
  return text.replace(/-?\d+(\.\d+)?/g, "#");
}

function show(severity: Severity, text: string, actions: readonly Action[] = []): void {
  const same = toasts.value.find(
    (toast) => kind(toast.text) === kind(text) && toast.severity === severity,
  );
  const toast = same
    ? { ...same, text, actions, count: same.count + 1 }
    : { key: nextKey++, severity, text, actions, count: 1 };
  if (same) {
    toasts.value = toasts.value.map((other) =>
      other.key === same.key ? toast : other,
    );
  } else {
    const kept = [...toasts.value];
    while (kept.length >= SHOW) {
      const expendable = kept.findIndex((other) => other.severity !== "error");
      const [gone] = kept.splice(Math.max(0, expendable), 1);
      if (gone) clearTimeout(timers.get(gone.key));
    }
    toasts.value = [...kept, toast];
  }
  clearTimeout(timers.get(toast.key));
  if (SHOWN_FOR_MS[severity] === Infinity || actions.length > 0) return;
  timers.set(
    toast.key,
    setTimeout(() => {
      dismiss(toast.key);
    }, SHOWN_FOR_MS[severity]),
  );
}

function keep(notice: Notice): void {
  notices.value = [...notices.value, notice].slice(-KEEP);
}

/** Report something that this page noticed itself; its number in the log is 0. */
export function report(
  severity: Severity,
  text: string,
  actions: readonly Action[] = [],
): void {
  keep({
    type: "notice",
    number: 0,
    wall_time: Date.now() / 1000,
    time: null,
    severity,
    code: "log",
    text,
  });
  show(severity, text, actions);
}

/** Shown elsewhere on the page: by a banner, in the bar, or beside the control. */
const QUIET: readonly Notice["code"][] = [
  "emergency_stop",
  "fault",
  "overrun",
  "stall",
  "refused",
];

function isLoud(notice: Notice): boolean {
  return notice.severity !== "info" && !QUIET.includes(notice.code);
}

/** Show a notice of the server; successes are in the log only. */
export function showNotice(notice: Notice): void {
  keep(notice);
  if (isLoud(notice)) show(notice.severity, notice.text);
}

/** Start with the notices that the server kept, summed up in one toast. */
export function replaceNotices(known: readonly Notice[]): void {
  for (const toast of toasts.value) dismiss(toast.key);
  notices.value = known;
  const count = known.filter(isLoud).length;
  const isRecorded = view.peek()?.mode === "replay";
  if (count > 0 && !isRecorded) show("warning", t("notices.earlier", { count }));
}
