/** Depth as colours, with the scale that they have. */

/** An image of depths, row by row from the top. */
export interface Depths {
  readonly width: number;
  readonly height: number;
  /** [mm]; 0 where it is not known. */
  readonly mm: Uint16Array;
}

/** Return the depths that the server has put into the colours of an image. */
export function depthsOf({ data, width, height }: ImageData): Depths {
  const mm = new Uint16Array(width * height);
  for (let i = 0; i < mm.length; i++) {
    mm[i] = 256 * (data[4 * i] ?? 0) + (data[4 * i + 1] ?? 0);
  }
  return { width, height, mm };
}

/** Parts of the known depths below the scale and up to its end: a horizon is far away. */
const [NEAREST, FARTHEST] = [0.01, 0.9];

/** Return from where to where the scale of an image goes [mm]; null: nothing is known. */
export function rangeOf({ mm }: Depths): [number, number] | null {
  const counts = new Uint32Array(65536);
  for (const one of mm) counts[one] = (counts[one] ?? 0) + 1;
  const known = mm.length - (counts[0] ?? 0);
  if (known === 0) return null;
  let from: number | undefined;
  let sum = 0;
  for (let depth = 1; depth < counts.length; depth++) {
    sum += counts[depth] ?? 0;
    if (sum >= NEAREST * known) from ??= depth;
    if (from !== undefined && sum >= FARTHEST * known) return [from, depth];
  }
  return null;
}

/** Colours from near to far, as red, green and blue, 0 … 255. */
const COLOURS = Array.from({ length: 256 }, (_one, i) => turbo(1 - i / 255));
/** Where nothing is known. */
const UNKNOWN = [40, 44, 52] as const;

/**
 * Return a colour of Turbo, by its polynomial approximation:
 * https://gist.github.com/mikhailov-work/0d177465a8151eb6ede1768d51d476c7
 */
function turbo(x: number): [number, number, number] {
  const polynomial = (...factors: number[]) => {
    const value = factors.reduceRight((sum, factor) => sum * x + factor, 0);
    return Math.round(255 * Math.max(0, Math.min(1, value)));
  };
  return [
    polynomial(
      0.13572138,
      4.6153926,
      -42.66032258,
      132.13108234,
      -152.94239396,
      59.28637943,
    ),
    polynomial(
      0.09140261,
      2.19418839,
      4.84296658,
      -14.18503333,
      4.27729857,
      2.82956604,
    ),
    polynomial(
      0.1066733,
      12.64194608,
      -60.58204836,
      110.36276771,
      -89.90310912,
      27.34824973,
    ),
  ];
}

/** Return the colour of a part of the scale, 0 near … 1 far, as CSS. */
export function colourAt(part: number): string {
  const [r, g, b] = COLOURS[Math.round(255 * part)] ?? UNKNOWN;
  return `rgb(${String(r)} ${String(g)} ${String(b)})`;
}

/** Paint depths between `from` and `to` [mm] into `data`: red, green, blue and opacity. */
export function paint(
  { mm }: Depths,
  [from, to]: readonly [number, number],
  data: Uint8ClampedArray,
): void {
  const scale = 255 / Math.max(1, to - from);
  mm.forEach((depth, i) => {
    const part = Math.max(0, Math.min(255, Math.round(scale * (depth - from))));
    const [r, g, b] = depth === 0 ? UNKNOWN : (COLOURS[part] ?? UNKNOWN);
    data[4 * i] = r;
    data[4 * i + 1] = g;
    data[4 * i + 2] = b;
    data[4 * i + 3] = 255;
  });
}
