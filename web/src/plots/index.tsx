/** The plots: any signal of the robot, in panes with a common time axis. */
import { useRef } from "preact/hooks";
import { t } from "../i18n";
import { selected, titleOf } from "../robots";
import { view } from "../store";
import { Button, IconButton } from "../ui/button";
import { Segmented } from "../ui/choice";
import { save } from "../ui/download";
import { DownloadIcon, PauseIcon, PlayIcon, PlusIcon, ResetIcon } from "../ui/icons";
import { token } from "../ui/theme";
import { colourOf } from "./chart";
import { csvOf } from "./csv";
import { PictureIcon } from "./icons";
import { pngOf } from "./image";
import {
  addPane,
  canAddPane,
  layout,
  resetLayout,
  seconds,
  show,
  WINDOWS,
} from "./layout";
import "./live";
import { signalName } from "./names";
import { PlotPane, type Shown } from "./pane";
import "./plots.css";
import { follow, held, hold, shownSource, visible } from "./range";
import type { SignalInfo } from "./signals";

function title(): string {
  const whole = view.value?.robot.title ?? "tool0";
  return selected.value === null ? whole : titleOf(selected.value);
}

/** Save the visible samples of all panes. */
async function saveCsv(): Promise<void> {
  const source = shownSource.value;
  const ids = [...new Set(layout.value.flatMap((pane) => pane.map(({ id }) => id)))];
  const signals = ids
    .map((id) => source.signals.value.get(id))
    .filter((info): info is SignalInfo => info !== undefined);
  const known = signals.map(({ id }) => id);
  const samples = await source.exact(known, ...visible());
  save(new Blob([csvOf(samples, signals)], { type: "text/csv" }), "tool0-plots.csv");
}

async function savePng(panes: readonly Shown[]): Promise<void> {
  const blob = await pngOf({
    title: title(),
    charts: panes.map(({ canvas, lines }) => ({
      plot: canvas(),
      legend: lines.map(({ signal, colour, scale }) => ({
        colour: colourOf(colour),
        text: `${signalName(signal)} [${scale.symbol}]`,
      })),
    })),
    colours: {
      background: token("--surface"),
      text: token("--text"),
      font: token("--font"),
    },
  });
  save(blob, "tool0-plots.png");
}

export default function PlotsPanel() {
  const shown = useRef(new Map<number, Shown>());
  const isHeld = held.value !== null;
  return (
    <div class="plots" data-testid="plots">
      <div class="plots-bar">
        <Segmented
          label={t("plots.window")}
          value={isHeld ? "" : String(seconds.value)}
          choices={WINDOWS.map((value) => ({
            value: String(value),
            label: value < 60 ? `${String(value)} s` : `${String(value / 60)} min`,
            testId: `plots-window-${String(value)}`,
          }))}
          onChange={(value) => {
            show(Number(value));
            follow();
          }}
        />
        <Button
          aria-pressed={isHeld}
          data-testid="plots-pause"
          onClick={() => {
            if (isHeld) follow();
            else hold(visible());
          }}
        >
          {isHeld ? <PlayIcon /> : <PauseIcon />}
          {t(isHeld ? "plots.follow" : "plots.pause")}
        </Button>
        <span class="plots-space" />
        <span class="plots-hint plots-help">{t("plots.help")}</span>
        <Button
          disabled={!canAddPane.value}
          data-testid="plots-add-pane"
          onClick={addPane}
        >
          <PlusIcon />
          {t("plots.addPane")}
        </Button>
        <IconButton
          label={t("plots.reset")}
          data-testid="plots-reset"
          onClick={resetLayout}
        >
          <ResetIcon />
        </IconButton>
        <IconButton
          label={t("plots.csv")}
          data-testid="plots-csv"
          onClick={() => void saveCsv()}
        >
          <DownloadIcon />
        </IconButton>
        <IconButton
          label={t("plots.png")}
          data-testid="plots-png"
          onClick={() => {
            const panes = [...shown.current.entries()].sort(([a], [b]) => a - b);
            void savePng(panes.map(([, one]) => one));
          }}
        >
          <PictureIcon />
        </IconButton>
      </div>
      <div class="plots-panes">
        {layout.value.map((pane, index) => (
          <PlotPane
            key={index}
            index={index}
            pane={pane}
            onShown={(at, one) => {
              if (one === null) shown.current.delete(at);
              else shown.current.set(at, one);
            }}
          />
        ))}
      </div>
    </div>
  );
}
