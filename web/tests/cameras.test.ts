import { describe, expect, test } from "vitest";
import { colourAt, depthsOf, paint, rangeOf } from "../src/cameras/depth";
import { stored } from "../src/cameras/state";

/** An image of one row, with these depths [mm] in red and green. */
function encoded(...mm: number[]): ImageData {
  const data = new Uint8ClampedArray(
    mm.flatMap((one) => [one >> 8, one & 255, 0, 255]),
  );
  return { data, width: mm.length, height: 1, colorSpace: "srgb" };
}

describe("depth", () => {
  test("is decoded to the millimetre", () => {
    expect([...depthsOf(encoded(0, 1, 255, 256, 65534)).mm]).toEqual([
      0, 1, 255, 256, 65534,
    ]);
  });

  test("has a scale that leaves out what is unknown or far away", () => {
    const near = Array.from({ length: 95 }, (_one, i) => 1000 + i);
    const far = Array.from({ length: 5 }, () => 20_000);
    expect(rangeOf(depthsOf(encoded(0, 0, ...near, ...far)))).toEqual([1000, 1089]);
    expect(rangeOf(depthsOf(encoded(0, 0)))).toBeNull();
    expect(rangeOf(depthsOf(encoded(500)))).toEqual([500, 500]);
  });

  test("is painted in the colours of its scale, and what is unknown in none of them", () => {
    const depths = depthsOf(encoded(1000, 2000, 9000, 0));
    const data = new Uint8ClampedArray(16);
    paint(depths, [1000, 2000], data);
    const colour = (i: number) =>
      `rgb(${[...data.slice(4 * i, 4 * i + 3)].map(String).join(" ")})`;
    expect(colour(0)).toBe(colourAt(0));
    expect(colour(1)).toBe(colourAt(1));
    expect(colour(2)).toBe(colourAt(1));
    expect(new Set([colourAt(0), colourAt(0.5), colourAt(1), colour(3)]).size).toBe(4);
    expect([3, 7, 11, 15].map((i) => data[i])).toEqual([255, 255, 255, 255]);
  });
});

test("stored settings that make no sense are left out", () => {
  const wrist = { isOpen: true, kind: "depth", width: 640 };
  const text = JSON.stringify({
    wrist,
    scene: { ...wrist, width: 5000 },
    other: { ...wrist, kind: "thermal" },
    broken: 3,
  });
  expect(stored(text)).toEqual({ wrist });
  for (const damaged of [undefined, "", "{", "null", "[1]"]) {
    expect(stored(damaged)).toEqual({});
  }
});
