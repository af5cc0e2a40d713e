/** The page: a bar that is always there, the scene with its plots, and the panels beside. */
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { boxes } from "./control-box";
import { t } from "./i18n";
import { Banners } from "./panels/banners";
import { Confirmation } from "./panels/confirmation";
import { ControlBoxPanel } from "./panels/control-box";
import { ControllersPanel } from "./panels/controllers";
import { DriveBar } from "./panels/drive-bar";
import { engageOnEscape } from "./panels/estop";
import { LogPanel } from "./panels/log";
import { MotionPanel } from "./panels/motion";
import { ObjectsPanel } from "./panels/objects";
import { RobotBar } from "./panels/robot-bar";
import { Toasts } from "./panels/toasts";
import { TopBar } from "./panels/top-bar";
import { TreePanel } from "./panels/tree";
import { connectionState, view } from "./store";
import { Tabs } from "./ui/choice";
import { ChevronDownIcon, ChevronUpIcon, PlotIcon } from "./ui/icons";
import { Lazy } from "./ui/lazy";
import { recall, remember } from "./ui/memory";

const TABS = ["motion", "objects", "controllers", "io", "tree", "log"] as const;
type Tab = (typeof TABS)[number];
/** Tabs that a view without physics lacks. */
const SIMULATED: readonly Tab[] = ["objects", "controllers", "io"];

const PANELS = {
  motion: MotionPanel,
  objects: ObjectsPanel,
  controllers: ControllersPanel,
  io: ControlBoxPanel,
  tree: TreePanel,
  log: LogPanel,
};

const tab = signal<Tab>("motion");
const plotsOpen = signal(recall("plots", ["open", "closed"]) === "open");

const loadScene = () => import("./scene");
const loadPlots = () => import("./plots");

export function App() {
  useEffect(() => {
    document.addEventListener("keydown", engageOnEscape, { capture: true });
    return () => {
      document.removeEventListener("keydown", engageOnEscape, { capture: true });
    };
  }, []);
  useEffect(() => {
    // the plots keep recording while their drawer is closed; the scene comes first
    void loadScene().then(() => import("./plots/state"));
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
      <TopBar />
      <Banners />
      <Confirmation />
      <main class="work">
        <section class="stage" aria-label={t("app.scene")}>
          <div class="scene">
            <Lazy load={loadScene} />
            <Toasts />
          </div>
          <PlotsDrawer />
        </section>
        <Column />
      </main>
    </>
  );
}

function PlotsDrawer() {
  const isOpen = plotsOpen.value;
  return (
    <section class="drawer" aria-label={t("app.plots")}>
      <button
        type="button"
        class="drawer-handle"
        aria-expanded={isOpen}
        aria-controls="plots"
        data-testid="plots-toggle"
        onClick={() => {
          plotsOpen.value = !isOpen;
          remember("plots", isOpen ? "closed" : "open");
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
  const isView = view.value?.mode === "view";
  const tabs = TABS.filter((name) => !isView || !SIMULATED.includes(name)).filter(
    (name) => name !== "io" || boxes.value.length > 0,
  );
  const shown = tabs.includes(tab.value) ? tab.value : "motion";
  const Panel = PANELS[shown];
  return (
    <aside class="column" id="controls" tabIndex={-1} aria-label={t("app.controls")}>
      <DriveBar />
      <RobotBar />
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
