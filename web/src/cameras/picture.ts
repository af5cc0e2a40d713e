/** Draws the images of a camera into a canvas, and measures in them. */
import { type Depths, depthsOf, paint, rangeOf } from "./depth";
import type { ImageKind } from "./state";
import type { Image } from "./stream";

/** Over which images are counted [ms]. */
const SPAN_MS = 2000;

export class Picture {
  private readonly context: CanvasRenderingContext2D;
  private depths: Depths | null = null;
  /** Ends of the scale [mm]; null: nothing is known, or it is no depth. */
  range: [number, number] | null = null;
  private arrivals: number[] = [];

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly kind: ImageKind,
  ) {
    const context = canvas.getContext("2d", {
      alpha: false,
      willReadFrequently: kind === "depth",
    });
    if (!context) throw new Error("this browser draws no canvas");
    this.context = context;
  }

  draw({ bitmap }: Image): void {
    const { canvas, context } = this;
    if (canvas.width !== bitmap.width) canvas.width = bitmap.width;
    if (canvas.height !== bitmap.height) canvas.height = bitmap.height;
    context.drawImage(bitmap, 0, 0);
    const now = performance.now();
    this.arrivals = [...this.arrivals.filter((one) => now - one < SPAN_MS), now];
    if (this.kind === "color") return;
    const image = context.getImageData(0, 0, canvas.width, canvas.height);
    this.depths = depthsOf(image);
    this.range = rangeOf(this.depths);
    paint(this.depths, this.range ?? [0, 1], image.data);
    context.putImageData(image, 0, 0);
  }

  /** Images per second [wall time], over the last two seconds. */
  rate(): number {
    const now = performance.now();
    return (1000 * this.arrivals.filter((one) => now - one < SPAN_MS).length) / SPAN_MS;
  }

  /** Return the depth at a place of the canvas, each part 0 … 1 [m]; null: not known. */
  depthAt(x: number, y: number): number | null {
    if (this.depths === null) return null;
    const { width, height, mm } = this.depths;
    const column = Math.min(width - 1, Math.floor(x * width));
    const row = Math.min(height - 1, Math.floor(y * height));
    const depth = mm[row * width + column] ?? 0;
    return depth === 0 ? null : depth / 1000;
  }
}
