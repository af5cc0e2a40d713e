/** The plots as a picture, with title and legends. */

export interface Legend {
  readonly colour: string;
  readonly text: string;
}

/** A chart, with the names of its lines. */
export interface ChartPicture {
  readonly plot: HTMLCanvasElement;
  readonly legend: readonly Legend[];
}

export interface Picture {
  readonly title: string;
  /** From top to bottom; at least one. */
  readonly charts: readonly ChartPicture[];
  readonly colours: { background: string; text: string; font: string };
}

const PADDING = 16;
const LINE = 20;

/** Return a PNG of `picture`. */
export function pngOf(picture: Picture): Promise<Blob> {
  const { title, charts, colours } = picture;
  const ratio = window.devicePixelRatio;
  const width = Math.max(...charts.map(({ plot }) => plot.width)) / ratio;
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser draws no canvas");

  context.font = `12px ${colours.font}`;
  const measure = (text: string) => context.measureText(text).width;
  const placed = charts.map(({ plot, legend }) => {
    const places = placesOf(legend, width, measure);
    const rows = (places.at(-1)?.row ?? -1) + 1;
    return { plot, places, top: rows * LINE + 4, height: plot.height / ratio };
  });
  const heights = placed.map(({ top, height }) => top + height);
  const total = heights.reduce((sum, one) => sum + one, 2 * PADDING + LINE);
  canvas.width = Math.round((width + 2 * PADDING) * ratio);
  canvas.height = Math.round(total * ratio);
  context.scale(ratio, ratio);
  context.fillStyle = colours.background;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.textBaseline = "middle";
  context.fillStyle = colours.text;
  context.font = `600 14px ${colours.font}`;
  context.fillText(title, PADDING, PADDING + LINE / 2 - 2);
  context.font = `12px ${colours.font}`;
  let y = PADDING + LINE;
  for (const { plot, places, top, height } of placed) {
    for (const { entry, x, row } of places) {
      const middle = y + row * LINE + LINE / 2;
      context.fillStyle = entry.colour;
      context.fillRect(PADDING + x, middle - 1.5, 14, 3);
      context.fillStyle = colours.text;
      context.fillText(entry.text, PADDING + x + 20, middle);
    }
    context.drawImage(plot, PADDING, y + top, plot.width / ratio, height);
    y += top + height;
  }
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => {
      if (blob) resolve(blob);
      else reject(new Error("the picture could not be written"));
    });
  });
}

/** Return where the entries of a legend stand in rows of `width` [px]. */
export function placesOf(
  legend: readonly Legend[],
  width: number,
  measure: (text: string) => number,
): { entry: Legend; x: number; row: number }[] {
  let x = 0;
  let row = 0;
  return legend.map((entry) => {
    const wide = 20 + measure(entry.text);
    if (x > 0 && x + wide > width) {
      x = 0;
      row += 1;
    }
    const place = { entry, x, row };
    x += wide + 20;
    return place;
  });
}
