/** The chart of one pane, for as long as nothing but the numbers changes. */
import { effect, untracked } from "@preact/signals";
import { shownTheme } from "../ui/theme";
import { fixed } from "../ui/number-field";
import { Chart, type Line } from "./chart";
import { cursors, held, shownSource, visible } from "./range";

/** Interval between drawings [ms]. */
const INTERVAL_MS = 50;
/** Interval between texts for screen readers [ms]. */
const TEXT_MS = 2000;

interface ViewSetup {
  /** The element of the chart. */
  readonly host: HTMLElement;
  /** Has outputs by `data-signal`, and `data-cursor` for a cursor's value. */
  readonly legend: HTMLElement;
  readonly lines: readonly Line[];
  /** The number of axes to leave room for. */
  readonly axes: number;
}

export class View {
  private chart: Chart;
  /** Time under the pointer [s]. */
  private pointed: number | null = null;
  private request = 0;
  private drawnAt = -Infinity;
  private labelledAt = -Infinity;
  private readonly ends: (() => void)[];

  constructor(private readonly setup: ViewSetup) {
    const { host, lines } = setup;
    this.chart = this.made();
    const size = new ResizeObserver(() => {
      this.chart.resize(host.clientWidth, host.clientHeight);
    });
    size.observe(host);
    let theme = shownTheme.peek();
    const ids = lines.map(({ signal }) => signal.id);
    this.ends = [
      () => {
        size.disconnect();
      },
      effect(() => {
        if (theme === shownTheme.value) return;
        theme = shownTheme.value;
        this.chart.dispose();
        this.chart = this.made();
        this.draw();
      }),
      effect(() => {
        const source = shownSource.value;
        const release = untracked(() => source.need(ids));
        const end = source.listen(this.redraw);
        return () => {
          end();
          untracked(release);
        };
      }),
      held.subscribe(this.redraw),
      cursors.subscribe(this.redraw),
    ];
    this.draw();
  }

  get canvas(): HTMLCanvasElement {
    return this.chart.canvas;
  }

  dispose(): void {
    cancelAnimationFrame(this.request);
    for (const end of this.ends) end();
    this.chart.dispose();
  }

  private made(): Chart {
    const { host, lines, axes } = this.setup;
    return new Chart(host, lines, axes, (time) => {
      this.pointed = time;
      this.report();
    });
  }

  private readonly redraw = (): void => {
    this.request ||= requestAnimationFrame(this.tick);
  };

  private readonly tick = (now: number): void => {
    this.request = 0;
    if (now - this.drawnAt < INTERVAL_MS - 4) {
      this.redraw();
      return;
    }
    this.drawnAt = now;
    this.draw();
  };

  private draw(): void {
    const [from, to] = visible();
    Object.assign(this.setup.host.dataset, {
      from: from.toFixed(3),
      to: to.toFixed(3),
    });
    this.chart.update(shownSource.peek());
    this.report();
  }

  /** Write the values under the pointer, or the newest, and at the cursors. */
  private report(): void {
    const { lines, legend, host } = this.setup;
    const newest = this.chart.valuesAt(this.pointed ?? this.chart.newest);
    const [a, b] = cursors.peek();
    const atA = a === undefined ? [] : this.chart.valuesAt(a);
    const atB = b === undefined ? [] : this.chart.valuesAt(b);
    const parts: string[] = [];
    lines.forEach(({ signal, scale }, i) => {
      const [first, second] = [atA[i] ?? null, atB[i] ?? null];
      const value = newest[i] ?? null;
      const text = (one: number | null) =>
        one === null ? "–" : `${fixed(one, scale.digits)} ${scale.symbol}`.trim();
      const difference = first === null || second === null ? null : second - first;
      write(legend, signal.id, "now", text(value));
      write(legend, signal.id, "a", text(first));
      write(legend, signal.id, "b", text(second));
      write(legend, signal.id, "difference", text(difference));
      parts.push(`${signal.of} ${signal.quantity} ${text(value)}`);
    });
    const now = performance.now();
    if (now - this.labelledAt < TEXT_MS) return;
    this.labelledAt = now;
    host.setAttribute("aria-description", parts.join(", "));
  }
}

function write(legend: HTMLElement, id: string, cursor: string, text: string): void {
  const output = legend.querySelector(
    `[data-signal="${CSS.escape(id)}"][data-cursor="${cursor}"]`,
  );
  if (output && output.textContent !== text) output.textContent = text;
}
