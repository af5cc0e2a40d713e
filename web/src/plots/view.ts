/** One chart for as long as nothing but the numbers changes. */
import { effect } from "@preact/signals";
import { frames } from "../frames";
import { shownTheme } from "../ui/theme";
import { fixed } from "../ui/number-field";
import { Chart, type ChartSetup } from "./chart";
import type { Recording } from "./recording";

/** Interval between drawings [ms]. */
const INTERVAL_MS = 50;
/** Interval between texts for screen readers [ms]. */
const TEXT_MS = 2000;

interface ViewSetup extends Omit<ChartSetup, "frozen"> {
  readonly recording: Recording;
  readonly frozen: Recording | null;
  readonly title: string;
}

export class View {
  private chart: Chart;
  private cursor: number | null = null;
  private request = 0;
  private drawnAt = -Infinity;
  private labelledAt = -Infinity;
  private readonly ends: (() => void)[];

  /**
   * @param host of the chart
   * @param list has an output for each joint, by its `data-joint`
   */
  constructor(
    private readonly host: HTMLElement,
    private readonly list: HTMLElement,
    private readonly setup: ViewSetup,
  ) {
    this.chart = this.made();
    const size = new ResizeObserver(() => {
      this.chart.resize(host.clientWidth, host.clientHeight);
    });
    size.observe(host);
    let theme = shownTheme.peek();
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
      frames.listen(() => {
        if (!this.setup.frozen) this.request ||= requestAnimationFrame(this.tick);
      }),
    ];
    this.draw();
  }

  get visible(): [number, number] {
    return this.chart.visible;
  }

  get canvas(): HTMLCanvasElement {
    return this.chart.canvas;
  }

  dispose(): void {
    cancelAnimationFrame(this.request);
    for (const end of this.ends) end();
    this.chart.dispose();
    for (const output of this.list.querySelectorAll("output")) output.textContent = "";
  }

  private made(): Chart {
    const setup = { ...this.setup, frozen: this.setup.frozen !== null };
    return new Chart(this.host, setup, (index) => {
      this.cursor = index;
      this.report();
    });
  }

  private readonly tick = (now: number): void => {
    this.request = 0;
    if (now - this.drawnAt < INTERVAL_MS - 4) {
      this.request = requestAnimationFrame(this.tick);
      return;
    }
    this.drawnAt = now;
    this.draw();
  };

  private draw(): void {
    this.chart.update(this.setup.frozen ?? this.setup.recording);
    this.report();
  }

  /** Write the values under the cursor, or the newest, beside the names. */
  private report(): void {
    const { lines } = this.setup;
    const values = this.chart.valuesAt(this.cursor ?? this.chart.length - 1);
    const parts: string[] = [];
    lines.forEach(({ joint, scale }, i) => {
      const value = values[i]?.at(-1);
      const text =
        value == null ? "–" : `${fixed(value, scale.digits)} ${scale.symbol}`;
      parts.push(`${joint.name} ${text}`);
      const output = this.list.querySelector(
        `[data-joint="${CSS.escape(joint.name)}"]`,
      );
      if (output && output.textContent !== text) output.textContent = text;
    });
    const now = performance.now();
    if (now - this.labelledAt < TEXT_MS) return;
    this.labelledAt = now;
    this.host.setAttribute("aria-label", `${this.setup.title}: ${parts.join(", ")}`);
  }
}
