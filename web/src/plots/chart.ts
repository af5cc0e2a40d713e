/** The drawing of one pane with uPlot: data and style. */
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { token } from "../ui/theme";
import { handleGestures } from "./gestures";
import { COLOURS, limitsNear, rangeOf, type Scale, tickText } from "./quantities";
import { cursors, visible } from "./range";
import type { SignalInfo, SignalSource } from "./signals";

/** A signal that is drawn. */
export interface Line {
  readonly signal: SignalInfo;
  /** Number of its colour. */
  readonly colour: number;
  readonly scale: Scale;
}

export function colourOf(number: number): string {
  return token(`--plot-${String((number % COLOURS) + 1)}`);
}

/** A row of the table: a line, or what it should follow. */
interface Stroke {
  readonly id: string;
  readonly line: Line;
  readonly isDesired: boolean;
}

function strokesOf(lines: readonly Line[]): Stroke[] {
  return lines.flatMap((line) => {
    const { id, desired } = line.signal;
    const own: Stroke = { id, line, isDesired: false };
    return desired === undefined
      ? [own]
      : [{ id: desired, line, isDesired: true }, own];
  });
}

/** Return the units of lines, each of which has an axis. */
export function unitsOf(lines: readonly Line[]): string[] {
  return [...new Set(lines.map(({ scale }) => scale.symbol))];
}

/** Sides of a plot, as uPlot numbers them. */
const [RIGHT, LEFT] = [1, 3] as const;
/** Width of an axis with its label, and of a margin without an axis [px]. */
const AXIS = { values: 48, label: 16, none: 20 };

type Table = [number[], ...(number | null)[][]];

export class Chart {
  private readonly plot: uPlot;
  private readonly strokes: readonly Stroke[];
  /** What is drawn. */
  private table: Table = [[]];
  /** Unit → its visible limits [shown]. */
  private readonly limits = new Map<string, number[]>();
  private now = 0;
  private readonly endGestures: () => void;

  /**
   * @param axes the number of axes to leave room for
   * @param onCursor called with the time under the pointer [s], or null
   */
  constructor(
    host: HTMLElement,
    lines: readonly Line[],
    axes: number,
    onCursor: (time: number | null) => void,
  ) {
    this.strokes = strokesOf(lines);
    const units = unitsOf(lines);
    this.plot = new uPlot(
      {
        width: Math.max(120, host.clientWidth),
        height: Math.max(60, host.clientHeight),
        padding: paddingOf(units.length, axes),
        legend: { show: false },
        cursor: {
          y: false,
          drag: { x: false, y: false },
          points: { size: 7 },
          sync: { key: "plots" },
        },
        scales: {
          x: { time: false, range: () => visible() },
          ...Object.fromEntries(
            lines.map(({ scale }) => [scale.symbol, this.scaleOf(scale)]),
          ),
        },
        axes: [
          { ...axis(), values: (_plot, ticks) => ticks.map(timeText), size: 26 },
          ...units.map((unit, i) => this.axisOf(unit, i)),
        ],
        series: [{}, ...this.strokes.map(seriesOf)],
        hooks: {
          setCursor: [
            (plot) => {
              const left = plot.cursor.left ?? -1;
              onCursor(left < 0 ? null : plot.posToVal(left, "x"));
            },
          ],
          draw: [
            () => {
              this.drawLimits();
              this.drawTimes();
            },
          ],
        },
      },
      this.table,
      host,
    );
    this.endGestures = handleGestures(this.plot.over);
  }

  /** Draw what `source` has now. */
  update(source: SignalSource): void {
    const [from, to] = visible();
    const ids = this.strokes.map(({ id }) => id);
    const points = 2 * this.plot.bbox.width;
    const { times, values } = source.read(ids, from, to, points);
    this.now = source.now();
    this.table = [[...times], ...values.map((row, i) => this.shown(row, i))];
    this.limits.clear();
    this.strokes.forEach(({ line }, i) => {
      const { symbol } = line.scale;
      const near = limitsNear(line.signal.limit, this.table[1 + i] ?? []);
      this.limits.set(symbol, [...(this.limits.get(symbol) ?? []), ...near]);
    });
    this.plot.setData(this.table);
  }

  resize(width: number, height: number): void {
    this.plot.setSize({ width: Math.max(120, width), height: Math.max(60, height) });
  }

  /** Return the shown value of each line at the sample nearest to a time [s]. */
  valuesAt(time: number): (number | null)[] {
    const [times, ...rows] = this.table;
    const after = times.findIndex((one) => one >= time);
    let index = after < 0 ? times.length - 1 : after;
    const [before, at] = [times[index - 1], times[index]];
    if (before !== undefined && at !== undefined && time - before < at - time)
      index -= 1;
    return rows
      .filter((_row, i) => this.strokes[i]?.isDesired === false)
      .map((row) => row[index] ?? null);
  }

  /** The time of the newest sample that is drawn, up to that of the playhead [s]. */
  get newest(): number {
    return Math.min(this.table[0].at(-1) ?? 0, Math.max(this.now, visible()[0]));
  }

  get canvas(): HTMLCanvasElement {
    return this.plot.ctx.canvas;
  }

  dispose(): void {
    this.endGestures();
    this.plot.destroy();
  }

  private shown(row: readonly (number | null)[], stroke: number): (number | null)[] {
    const factor = this.strokes[stroke]?.line.scale.factor ?? 1;
    return row.map((value) => (value === null ? null : factor * value));
  }

  private scaleOf({ symbol, digits }: Scale): uPlot.Scale {
    return {
      range: (_plot, least, most) =>
        rangeOf(least, most, digits, this.limits.get(symbol)),
    };
  }

  private axisOf(unit: string, index: number): uPlot.Axis {
    return {
      ...axis(),
      scale: unit,
      // eslint-disable-next-line @typescript-eslint/no-unsafe-enum-assignment -- a const enum
      side: index % 2 === 0 ? LEFT : RIGHT,
      label: unit,
      labelFont: `11px ${token("--font")}`,
      labelSize: AXIS.label,
      size: AXIS.values,
      values: (_plot, ticks, _axis, _space, apart) =>
        ticks.map((tick) => tickText(tick, apart)),
      grid: { show: index === 0, stroke: token("--plot-grid"), width: 1 },
    };
  }

  /** Draw the limits that values come near to, dotted. */
  private drawLimits(): void {
    this.drawClipped((context, { left, width }) => {
      context.setLineDash([2 * devicePixelRatio, 4 * devicePixelRatio]);
      context.strokeStyle = token("--text-3");
      for (const [unit, limits] of this.limits) {
        for (const limit of new Set(limits)) {
          const y = Math.round(this.plot.valToPos(limit, unit, true)) + 0.5;
          stroke(context, [left, y], [left + width, y]);
        }
      }
    });
  }

  /** Draw the placed cursors, and the present time where it is not the right edge. */
  private drawTimes(): void {
    const [, to] = visible();
    this.drawClipped((context, { top, height }) => {
      const line = (time: number) => {
        const x = Math.round(this.plot.valToPos(time, "x", true)) + 0.5;
        stroke(context, [x, top], [x, top + height]);
        return x;
      };
      context.strokeStyle = token("--text-3");
      context.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
      if (this.now < to) line(this.now);
      context.setLineDash([]);
      context.strokeStyle = context.fillStyle = token("--accent");
      context.font = `${String(11 * devicePixelRatio)}px ${token("--font")}`;
      context.textBaseline = "top";
      cursors.peek().forEach((time, i) => {
        const x = line(time);
        context.fillText("AB"[i] ?? "", x + 3 * devicePixelRatio, top);
      });
    });
  }

  private drawClipped(
    draw: (context: CanvasRenderingContext2D, box: uPlot.BBox) => void,
  ): void {
    const { ctx, bbox } = this.plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineWidth = devicePixelRatio;
    draw(ctx, bbox);
    ctx.restore();
  }
}

/** Return the padding of a chart with as much room at its sides as one with `wanted` axes. */
function paddingOf(axes: number, wanted: number): [number, number, number, number] {
  const width = AXIS.values + AXIS.label;
  const missing = (side: (count: number) => number) => side(wanted) - side(axes);
  const right = missing((count) => Math.floor(count / 2)) * width;
  const left = missing((count) => Math.ceil(count / 2)) * width;
  return [8, wanted > 1 ? right + 4 : AXIS.none, 0, left];
}

type Point = readonly [number, number];

function stroke(context: CanvasRenderingContext2D, from: Point, to: Point): void {
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}

function axis(): uPlot.Axis {
  return {
    stroke: token("--text-3"),
    font: `11px ${token("--font")}`,
    grid: { stroke: token("--plot-grid"), width: 1 },
    ticks: { show: false },
    gap: 6,
  };
}

function timeText(tick: number): string {
  return `${String(Number(tick.toFixed(3)))} s`;
}

function seriesOf({ id, line, isDesired }: Stroke): uPlot.Series {
  return {
    label: id,
    scale: line.scale.symbol,
    stroke: colourOf(line.colour),
    width: isDesired ? 1.25 : 1.75,
    ...(isDesired && { dash: [5, 4] }),
    points: { show: false },
    spanGaps: false,
  };
}
