import { signal } from "@preact/signals";
import { t } from "../i18n";
import { report } from "../notices";
import type { Notice } from "../protocol";
import { gathered, type Entry } from "../repeats";
import { passedNotices } from "../replayed";
import { IconButton } from "../ui/button";
import { Segmented } from "../ui/choice";
import { CopyIcon } from "../ui/icons";
import { SEVERITY_ICONS } from "./toasts";

type Filter = "all" | "warnings" | "errors";

const SHOWN: Record<Filter, readonly Notice["severity"][]> = {
  all: ["info", "warning", "error"],
  warnings: ["warning", "error"],
  errors: ["error"],
};
const filter = signal<Filter>("all");

function clock(notice: Notice): string {
  return new Date(notice.wall_time * 1000).toLocaleTimeString([], { hour12: false });
}

function asLine(notice: Notice): string {
  const when = new Date(notice.wall_time * 1000).toISOString();
  const time = notice.time === null ? "" : ` t=${notice.time.toFixed(3)}`;
  return `${when}${time} ${notice.severity.toUpperCase()} ${notice.code}: ${notice.text}`;
}

export function LogPanel() {
  const shown = passedNotices.value.filter((notice) =>
    SHOWN[filter.value].includes(notice.severity),
  );
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(shown.map(asLine).join("\n"));
      report("info", t("app.copied"));
    } catch (reason) {
      report("error", String(reason));
    }
  };
  return (
    <section class="group log" aria-labelledby="log-title">
      <header>
        <h2 id="log-title">{t("log.title")}</h2>
        <div class="row">
          <Segmented
            label={t("log.filter")}
            value={filter.value}
            data-testid="log-filter"
            choices={(["all", "warnings", "errors"] as const).map((value) => ({
              value,
              label: t(`log.${value}`),
              testId: `log-${value}`,
            }))}
            onChange={(chosen) => {
              filter.value = chosen;
            }}
          />
          <IconButton label={t("log.copy")} onClick={() => void copy()}>
            <CopyIcon />
          </IconButton>
        </div>
      </header>
      {shown.length === 0 && <p class="muted">{t("log.empty")}</p>}
      <ol>
        {gathered(shown)
          .map((entry, index) => <Row key={index} entry={entry} />)
          .reverse()}
      </ol>
    </section>
  );
}

function Row({ entry: { notice, count } }: { entry: Entry }) {
  const Icon = SEVERITY_ICONS[notice.severity];
  return (
    <li class={notice.severity} data-testid="log-entry" data-code={notice.code}>
      <Icon />
      <div>
        <p class="muted">
          <span class="visually-hidden">{t(`severity.${notice.severity}`)} </span>
          <time>{clock(notice)}</time>
          {notice.time !== null && <span>t = {notice.time.toFixed(2)} s</span>}
          {count > 1 && <span>×{count}</span>}
        </p>
        <p>{notice.text}</p>
      </div>
    </li>
  );
}
