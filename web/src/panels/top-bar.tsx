import { language, speak, t } from "../i18n";
import { silence } from "../silence";
import { connectionState, isLive, offers, status, view } from "../store";
import { Badge } from "../ui/badge";
import type { Tone } from "../ui/badge";
import { Segmented } from "../ui/choice";
import { MenuIcon, MoonIcon, SunIcon, SystemIcon } from "../ui/icons";
import { useMedia } from "../ui/media";
import { Menu } from "../ui/menu";
import { theme } from "../ui/theme";
import { Banners } from "./banners";
import { EmergencyStop } from "./estop";
import { RecordButton } from "./recording";
import { Readings, RunButton, SimulatedTime, TimeControls } from "./simulation";

const TONES: Record<typeof connectionState.value, Tone> = {
  connecting: "neutral",
  open: "ok",
  lost: "warning",
  refused: "danger",
  outdated: "danger",
};

/** One row holds neither the time controls nor the preferences, as in layout.css. */
const NARROW = "(max-width: 959px)";
/** One row does not hold the preferences. */
const MEDIUM = "(max-width: 1099px)";

export function TopBar() {
  const robot = view.value?.robot;
  const isNarrow = useMedia(NARROW);
  const hasMenu = useMedia(MEDIUM);
  const hasTime = isLive.value;
  return (
    <header class="bar">
      <div class="brand">
        <Mark />
        <h1>
          <b>tool0</b>
          {robot && <span class="muted">{robot.title}</span>}
        </h1>
      </div>
      {hasTime && (
        <div class="simulation" role="group" aria-label={t("simulation.group")}>
          <RunButton />
          {offers("start_recording") && <RecordButton />}
          {!isNarrow && <TimeControls />}
          {isNarrow ? (
            <dl class="readings">
              <SimulatedTime />
            </dl>
          ) : (
            <Readings />
          )}
        </div>
      )}
      <div class="settings">
        {view.value?.grasp_assist === true && (
          <span class="assist" title={t("assist.explain")}>
            <Badge tone="warning" data-testid="grasp-assist">
              {t("assist.badge")}
            </Badge>
          </span>
        )}
        <Connection />
        {hasMenu ? (
          <Menu label={t("layout.menu")} icon={<MenuIcon />} data-testid="menu">
            {hasTime && isNarrow && (
              <div class="simulation">
                <TimeControls />
                <Readings />
              </div>
            )}
            <Preferences />
          </Menu>
        ) : (
          <Preferences />
        )}
      </div>
      <EmergencyStop />
      <Banners />
    </header>
  );
}

function Preferences() {
  return (
    <>
      <Segmented
        label={t("app.language")}
        value={language.value}
        data-testid="language"
        choices={[
          { value: "en", label: "EN", name: "English", testId: "language-en" },
          { value: "zh", label: "中", name: "中文", testId: "language-zh" },
        ]}
        onChange={speak}
      />
      <Segmented
        label={t("app.theme")}
        value={theme.value}
        data-testid="theme"
        choices={[
          {
            value: "system",
            label: <SystemIcon />,
            name: t("theme.system"),
            testId: "theme-system",
          },
          {
            value: "light",
            label: <SunIcon />,
            name: t("theme.light"),
            testId: "theme-light",
          },
          {
            value: "dark",
            label: <MoonIcon />,
            name: t("theme.dark"),
            testId: "theme-dark",
          },
        ]}
        onChange={(chosen) => {
          theme.value = chosen;
        }}
      />
    </>
  );
}

function Connection() {
  const state = connectionState.value;
  const silent = silence.value;
  const clients = status.value?.clients ?? 1;
  return (
    <span
      class="connection"
      data-testid="connection"
      data-state={silent === null ? state : "silent"}
      title={state === "open" ? t("connection.clients", { count: clients }) : ""}
    >
      <Badge tone={silent === null ? TONES[state] : "danger"}>
        <span class="dot" />
        <span class="connection-text">
          {silent === null
            ? t(`connection.${state}`)
            : t("connection.silent", { seconds: silent.toFixed(1) })}
          {state === "open" &&
            silent === null &&
            clients > 1 &&
            ` · ${String(clients)}`}
        </span>
      </Badge>
    </span>
  );
}

function Mark() {
  return (
    <svg class="mark" viewBox="0 0 32 32" aria-hidden="true">
      <rect width="32" height="32" rx="7" />
      <path d="M8 26V16l7-7 6 3M21 7.5v3l3 2.5m-3-5.5 3-2.5" />
    </svg>
  );
}
