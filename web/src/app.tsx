/** The page: a bar that is always there, the scene with its plots, and the panels beside. */
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { openCameras } from "./cameras/state";
import { boxes } from "./control-box";
import { t } from "./i18n";
import type { Method } from "./messages";
import { Confirmation } from "./panels/confirmation";
import { ControlBoxPanel } from "./panels/control-box";
import { ControllersPanel } from "./panels/controllers";
import { DriveBar } from "./panels/drive-bar";
import { engageOnEscape } from "./panels/estop";
import { LogPanel } from "./panels/log";
import { MotionPanel } from "./panels/motion";
import { ObjectsPanel } from "./panels/objects";
import { RealRobotBar } from "./panels/real-robot-bar";
import { RobotBar } from "./panels/robot-bar";
import { ShortcutHelp } from "./panels/shortcut-help";
import { Toasts } from "./panels/toasts";
import { TopBar } from "./panels/top-bar";
import { TreePanel } from "./panels/tree";
import { onShortcut } from "./shortcuts";
import "./program/shortcuts";
import { connectionState, offers, status, view } from "./store";
import { Tabs } from "./ui/choice";
import { ChevronDownIcon, ChevronUpIcon, PlotIcon } from "./ui/icons";
import { Lazy } from "./ui/lazy";
import { useMedia } from "./ui/media";
import { rememberedFlag } from "./ui/memory";
import { Splitter } from "./ui/splitter";

const TABS = [
  "motion",
  "program",
  "objects",
  "controllers",
  "io",
  "tree",
  "log",
] as const;
type Tab = (typeof TABS)[number];
/** Tabs that are hidden if the robot offers none of these methods. */
const METHODS: Partial<Record<Tab, readonly Method[]>> = {
  program: ["run_program"],
  objects: ["add_object", "place_object", "remove_object"],
  controllers: ["list_controllers"],
  io: ["set_io", "play_program", "power_on"],
};
/** Tabs that a robot without an arm lacks. */
const OF_ARMS: readonly Tab[] = ["program", "io"];

const loadProgram = () => import("./panels/program");

function ProgramTab() {
  return <Lazy load={loadProgram} />;
}

const PANELS = {
  motion: MotionPanel,
  program: ProgramTab,
  objects: ObjectsPanel,
  controllers: ControllersPanel,
  io: ControlBoxPanel,
  tree: TreePanel,
  log: LogPanel,
};

const tab = signal<Tab>("motion");
const plotsOpen = rememberedFlag("plots", ["closed", "open"]);

const loadScene = () => import("./scene");
const loadTimeline = () => import("./timeline");
const loadPlots = () => import("./plots");
const loadCameras = () => import("./cameras");
const loadEpisodes = () => import("./panels/episodes");

/** Scene and controls are side by side, as in layout.css. */
const WIDE = "(min-width: 960px)";
/** *Motion* has room beside *Program*, as in layout.css: who teaches needs both. */
const TWO_COLUMNS = "(min-width: 1600px)";

export function App() {
  const isWide = useMedia(WIDE);
  useEffect(() => {
    document.addEventListener("keydown", engageOnEscape, { capture: true });
    document.addEventListener("keydown", onShortcut);
    return () => {
      document.removeEventListener("keydown", engageOnEscape, { capture: true });
      document.removeEventListener("keydown", onShortcut);
    };
  }, []);
  useEffect(() => {
    // the plots keep recording while their drawer is closed; the scene comes first
    void loadScene().then(() => import("./plots/live"));
  }, []);
  useEffect(() => {
    const title = view.value?.robot.title;
    document.title = title === undefined ? "tool0" : `${title} – tool0`;
  }, [view.value]);

  return (
    <>
      <a class="skip" href="#controls">
        {t("app.skip")}
      </a>
      <RealRobotBar />
      <TopBar />
      <Confirmation />
      <ShortcutHelp />
      <main class="work">
        <section class="stage" aria-label={t("app.scene")}>
          <div class="scene">
            <Lazy load={loadScene} />
            {openCameras.value.length > 0 && <Lazy load={loadCameras} />}
            <Toasts />
          </div>
          <Lazy load={loadTimeline} />
          <PlotsDrawer />
        </section>
        {isWide && (
          <Splitter
            label={t("layout.columnWidth")}
            name="column"
            grows="right"
            min={336}
            max={() => window.innerWidth * 0.6}
            initial={392}
          />
        )}
        <Column />
      </main>
    </>
  );
}

function PlotsDrawer() {
  const isOpen = plotsOpen.value;
  return (
    <section class="drawer" aria-label={t("app.plots")}>
      {isOpen && (
        <Splitter
          label={t("layout.plotsHeight")}
          name="plots-height"
          grows="below"
          min={140}
          max={() => window.innerHeight * 0.7}
          initial={Math.min(420, Math.max(220, window.innerHeight * 0.34))}
        />
      )}
      <button
        type="button"
        class="drawer-handle"
        aria-expanded={isOpen}
        aria-controls="plots"
        data-testid="plots-toggle"
        onClick={() => {
          plotsOpen.value = !isOpen;
        }}
      >
        <PlotIcon />
        {t("app.plots")}
        {isOpen ? <ChevronDownIcon /> : <ChevronUpIcon />}
      </button>
      {isOpen && (
        <div id="plots" class="drawer-content">
          <Lazy load={loadPlots} />
        </div>
      )}
    </section>
  );
}

function Column() {
  const tabs = TABS.filter((name) => {
    const methods = METHODS[name];
    return view.value === null || methods === undefined || offers(...methods);
  }).filter((name) => !OF_ARMS.includes(name) || boxes.value.length > 0);
  const shown = tabs.includes(tab.value) ? tab.value : "motion";
  const Panel = PANELS[shown];
  const isDouble = useMedia(TWO_COLUMNS) && shown === "program";
  return (
    <aside
      class={isDouble ? "column double" : "column"}
      id="controls"
      tabIndex={-1}
      aria-label={t("app.controls")}
    >
      <DriveBar />
      <RobotBar />
      {(status.value?.episodes ?? null) !== null && <Lazy load={loadEpisodes} />}
      <Tabs
        label={t("app.controls")}
        value={shown}
        choices={tabs.map((name) => ({
          value: name,
          label: t(`tab.${name}`),
          testId: `tab-${name}`,
        }))}
        onChange={(chosen) => {
          tab.value = chosen;
        }}
      />
      {isDouble && (
        <section class="panel beside" aria-label={t("tab.motion")}>
          <MotionPanel />
        </section>
      )}
      <div
        class="panel"
        role="tabpanel"
        id={`panel-${shown}`}
        aria-labelledby={`tab-${shown}`}
      >
        {view.value ? (
          <Panel />
        ) : (
          <p class="placeholder">{t(`connection.${connectionState.value}`)}</p>
        )}
        <footer class="about">
          <a href="./licenses.md" target="_blank" rel="noopener" data-testid="licenses">
            {t("app.licenses")}
          </a>
        </footer>
      </div>
    </aside>
  );
}
