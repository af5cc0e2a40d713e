/** The plot as a picture, with its title and legend. */

export interface Legend {
  readonly colour: string;
  readonly text: string;
}

export interface Picture {
  readonly plot: HTMLCanvasElement;
  readonly title: string;
  readonly legend: readonly Legend[];
  readonly colours: { background: string; text: string; font: string };
}

const PADDING = 16;
const LINE = 20;

/** Return a PNG of `picture`. */
export function pngOf(picture: Picture): Promise<Blob> {
  const { plot, title, legend, colours } = picture;
  const ratio = window.devicePixelRatio;
  const width = plot.width / ratio;
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser draws no canvas");

  context.font = `12px ${colours.font}`;
  const places = placesOf(legend, width, (text) => context.measureText(text).width);
  const rows = (places.at(-1)?.row ?? 0) + 1;
  const top = PADDING + LINE + rows * LINE + 4;
  canvas.width = Math.round((width + 2 * PADDING) * ratio);
  canvas.height = Math.round((top + PADDING) * ratio) + plot.height;
  context.scale(ratio, ratio);
  context.fillStyle = colours.background;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.textBaseline = "middle";
  context.fillStyle = colours.text;
  context.font = `600 14px ${colours.font}`;
  context.fillText(title, PADDING, PADDING + LINE / 2 - 2);
  context.font = `12px ${colours.font}`;
  for (const { entry, x, row } of places) {
    const y = PADDING + LINE + row * LINE + LINE / 2;
    context.fillStyle = entry.colour;
    context.fillRect(PADDING + x, y - 1.5, 14, 3);
    context.fillStyle = colours.text;
    context.fillText(entry.text, PADDING + x + 20, y);
  }
  context.drawImage(plot, PADDING, top, width, plot.height / ratio);
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

/** Download a file. */
export function save(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => {
    URL.revokeObjectURL(link.href);
  }, 10_000);
}
