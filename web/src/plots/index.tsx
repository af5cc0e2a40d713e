/** The plots: measured and desired joint values over the last seconds. */
import { useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { type Key, t } from "../i18n";
import { selected, titleOf } from "../robots";
import { view } from "../store";
import { Button, IconButton } from "../ui/button";
import { Segmented } from "../ui/choice";
import { DownloadIcon } from "../ui/icons";
import { token } from "../ui/theme";
import { colourOf } from "./chart";
import { csvOf } from "./csv";
import { FreezeIcon, PictureIcon } from "./icons";
import { pngOf, save } from "./image";
import { JointList } from "./joint-list";
import "./plots.css";
import { type Plotted, PLOTTED } from "./quantities";
import { freeze, frozen, lines, plotted, recording, seconds, WINDOWS } from "./state";
import { View } from "./view";

const NAMES: Record<Plotted, Key> = {
  position: "plots.position",
  error: "plots.error",
  velocity: "plots.velocity",
  effort: "plots.effort",
};

function title(): string {
  const whole = view.value?.robot.title ?? "tool0";
  const robot = selected.value === null ? whole : titleOf(selected.value);
  return `${robot} – ${t(NAMES[plotted.value])}`;
}

function saveCsv(view: View): void {
  const [from, to] = view.visible;
  const text = csvOf(frozen.value ?? recording.value, lines.value, from, to);
  save(new Blob([text], { type: "text/csv" }), `tool0-${plotted.value}.csv`);
}

async function savePng(view: View): Promise<void> {
  const legend = lines.value.map(({ joint, colour, scale }) => ({
    colour: colourOf(colour),
    text: `${joint.name} [${scale.symbol}]`,
  }));
  const blob = await pngOf({
    plot: view.canvas,
    title: plotted.value === "position" ? `${title()} (${t("plots.dashed")})` : title(),
    legend,
    colours: {
      background: token("--surface"),
      text: token("--text"),
      font: token("--font"),
    },
  });
  save(blob, `tool0-${plotted.value}.png`);
}

export default function PlotsPanel() {
  const host = useRef<HTMLDivElement>(null);
  const list = useRef<HTMLDivElement>(null);
  const view = useRef<View | null>(null);
  const isFrozen = frozen.value !== null;

  useSignalEffect(() => {
    if (!host.current || !list.current) return undefined;
    const made = new View(host.current, list.current, {
      plotted: plotted.value,
      lines: lines.value,
      seconds: seconds.value,
      frozen: frozen.value,
      recording: recording.value,
      title: title(),
    });
    view.current = made;
    return () => {
      view.current = null;
      made.dispose();
    };
  });

  return (
    <div class="plots" data-testid="plots">
      <div class="plots-bar">
        <Segmented
          label={t("plots.quantity")}
          value={plotted.value}
          choices={PLOTTED.map((value) => ({
            value,
            label: t(NAMES[value]),
            testId: `plots-${value}`,
          }))}
          onChange={(value) => {
            plotted.value = value;
          }}
        />
        <Segmented
          label={t("plots.window")}
          value={String(seconds.value)}
          choices={WINDOWS.map((value) => ({
            value: String(value),
            label: `${value} s`,
            testId: `plots-window-${value}`,
          }))}
          onChange={(value) => {
            seconds.value = Number(value);
          }}
        />
        <span class="plots-space" />
        {isFrozen && <span class="plots-hint">{t("plots.zoomHint")}</span>}
        <Button
          aria-pressed={isFrozen}
          data-testid="plots-freeze"
          onClick={() => {
            freeze(!isFrozen);
          }}
        >
          <FreezeIcon />
          {t("plots.freeze")}
        </Button>
        <IconButton
          label={t("plots.csv")}
          data-testid="plots-csv"
          onClick={() => {
            if (view.current) saveCsv(view.current);
          }}
        >
          <DownloadIcon />
        </IconButton>
        <IconButton
          label={t("plots.png")}
          data-testid="plots-png"
          onClick={() => {
            if (view.current) void savePng(view.current);
          }}
        >
          <PictureIcon />
        </IconButton>
      </div>
      <div class="plots-body">
        <JointList root={list} />
        <div class="plots-chart" ref={host} role="img" data-testid="plots-chart" />
      </div>
    </div>
  );
}
