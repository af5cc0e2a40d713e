/** The drawing of the plots with uPlot: data and style. */
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { token } from "../ui/theme";
import { COLOURS, limitsNear, type Plotted, rangeOf } from "./quantities";
import type { Recording } from "./recording";
import { type Line, strokesOf, type Table, tableOf } from "./series";

export interface ChartSetup {
  readonly plotted: Plotted;
  readonly lines: readonly Line[];
  /** Visible seconds while nothing is frozen. */
  readonly seconds: number;
  readonly frozen: boolean;
}

export function colourOf(number: number): string {
  return token(`--plot-${(number % COLOURS) + 1}`);
}

/** Draw the limits of effort as dotted lines. */
function drawLimits(plot: uPlot, lines: readonly Line[]): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([2 * devicePixelRatio, 4 * devicePixelRatio]);
  for (const { joint, colour } of lines) {
    if (joint.effort === null) continue;
    ctx.strokeStyle = colourOf(colour);
    for (const limit of [joint.effort, -joint.effort]) {
      const y = Math.round(plot.valToPos(limit, "y", true)) + 0.5;
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
  }
  ctx.restore();
}

export class Chart {
  private readonly plot: uPlot;
  /** What is drawn. */
  private table: Table = [[]];
  /** Visible limits of effort. */
  private limits: number[] = [];

  /** @param onCursor called with the index in the table under the cursor, or null */
  constructor(
    host: HTMLElement,
    private readonly setup: ChartSetup,
    onCursor: (index: number | null) => void,
  ) {
    const { plotted, lines, frozen } = setup;
    const axis = (label?: string): uPlot.Axis => ({
      stroke: token("--text-3"),
      font: `11px ${token("--font")}`,
      grid: { stroke: token("--plot-grid"), width: 1 },
      ticks: { show: false },
      gap: 6,
      ...(label !== undefined && { label, labelFont: `11px ${token("--font")}` }),
    });
    const units = [...new Set(lines.map(({ scale }) => scale.symbol))].join(", ");
    this.plot = new uPlot(
      {
        width: Math.max(120, host.clientWidth),
        height: Math.max(80, host.clientHeight),
        padding: [10, 24, 0, 0],
        legend: { show: false },
        cursor: {
          y: false,
          drag: { x: frozen, y: false, setScale: frozen },
          points: { size: 7 },
        },
        scales: {
          x: frozen ? { time: false } : { time: false, range: () => this.window() },
          y: { range: (_plot, least, most) => rangeOf(least, most, this.limits) },
        },
        axes: [
          {
            ...axis(),
            values: (_plot, ticks) => ticks.map((tick) => `${tick} s`),
            size: 30,
          },
          { ...axis(units), size: 52, labelSize: 18 },
        ],
        series: [
          {},
          ...lines.flatMap(({ joint, colour }) =>
            strokesOf(plotted).map((quantity): uPlot.Series => ({
              label: `${joint.name} ${quantity}`,
              stroke: colourOf(colour),
              width: quantity === "desired" ? 1.25 : 1.75,
              ...(quantity === "desired" && { dash: [5, 4] }),
              points: { show: false },
            })),
          ),
        ],
        hooks: {
          setCursor: [
            (plot) => {
              onCursor(plot.cursor.idx ?? null);
            },
          ],
          draw: [
            (plot) => {
              if (plotted === "effort") drawLimits(plot, lines);
            },
          ],
        },
      },
      this.table,
      host,
    );
  }

  /** Draw the present content of `recording`. */
  update(recording: Recording): void {
    const { lines, plotted, seconds, frozen } = this.setup;
    const newest = recording.time(recording.length - 1);
    const from = frozen || Number.isNaN(newest) ? -Infinity : newest - seconds;
    this.table = tableOf(recording, lines, plotted, from);
    if (plotted === "effort") {
      this.limits = lines.flatMap(({ joint }, i) =>
        limitsNear(joint.effort, this.table[1 + i] ?? []),
      );
    }
    this.plot.setData(this.table);
    if (frozen && recording.length > 0) {
      this.plot.setScale("x", { min: newest - seconds, max: newest });
    }
  }

  resize(width: number, height: number): void {
    this.plot.setSize({ width: Math.max(120, width), height: Math.max(80, height) });
  }

  /** Shown values at an index of the table: of each line, by stroke; null: not known. */
  valuesAt(index: number): (number | null)[][] {
    const strokes = strokesOf(this.setup.plotted).length;
    return this.setup.lines.map((_line, i) =>
      this.table
        .slice(1 + i * strokes, 1 + (i + 1) * strokes)
        .map((row) => row[index] ?? null),
    );
  }

  /** Number of samples in the table. */
  get length(): number {
    return this.table[0].length;
  }

  timeAt(index: number): number | undefined {
    return this.table[0][index];
  }

  /** The visible range of time, from and to [s]. */
  get visible(): [number, number] {
    const { min, max } = this.plot.scales.x ?? {};
    return [min ?? -Infinity, max ?? Infinity];
  }

  get canvas(): HTMLCanvasElement {
    return this.plot.ctx.canvas;
  }

  dispose(): void {
    this.plot.destroy();
  }

  private window(): [number, number] {
    // there is no time before zero
    const end = Math.max(this.table[0].at(-1) ?? 0, this.setup.seconds);
    return [end - this.setup.seconds, end];
  }
}
