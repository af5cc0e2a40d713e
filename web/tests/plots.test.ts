import { describe, expect, test } from "vitest";
import { csvOf } from "../src/plots/csv";
import { placesOf } from "../src/plots/image";
import { freeColour, limitsNear, rangeOf, scaleOf } from "../src/plots/quantities";
import { Recording } from "../src/plots/recording";
import { tableOf } from "../src/plots/series";
import type { Frame } from "../src/protocol";
import { frame, joint } from "./fixtures";

function frameAt(
  time: number,
  position: number[],
  desired: (number | null)[] = [],
): Frame {
  return frame({
    time,
    position,
    velocity: position.map((one) => 10 * one),
    effort: position.map((one) => 100 * one),
    desired: position.map((_one, i) => desired[i] ?? null),
  });
}

function times(recording: Recording): number[] {
  return Array.from({ length: recording.length }, (_one, i) => recording.time(i));
}

describe("a recording", () => {
  test("keeps the newest samples and forgets the oldest", () => {
    const recording = new Recording(1, 8, 1);
    for (let i = 0; i < 20; i++) recording.push(frameAt(i, [i]));
    expect(times(recording)).toEqual([12, 13, 14, 15, 16, 17, 18, 19]);
    expect(recording.value("position", 0, 0)).toBe(12);
    expect(recording.value("effort", 0, 7)).toBe(1900);
  });

  test("is cleared when time goes back", () => {
    const recording = new Recording(1);
    recording.push(frameAt(5, [1]));
    recording.push(frameAt(0, [2]));
    expect(times(recording)).toEqual([0]);
  });

  test("has one sample of an instant, the newest", () => {
    const recording = new Recording(1);
    recording.push(frameAt(1, [1]));
    recording.push(frameAt(2, [2]));
    recording.push(frameAt(2, [3]));
    expect(times(recording)).toEqual([1, 2]);
    expect(recording.value("position", 0, 1)).toBe(3);
  });

  test("holds its whole span in slow motion too, and always the newest sample", () => {
    const recording = new Recording(1, 100, 10);
    let time = 0;
    for (let i = 0; i < 5000; i++) {
      time = i * 0.004;
      recording.push(frameAt(time, [time]));
      expect(recording.time(recording.length - 1)).toBe(time);
    }
    expect(time - recording.time(0)).toBeGreaterThan(9);
    const steps = times(recording).map((one, i, all) => one - (all[i - 1] ?? -1));
    expect(Math.min(...steps)).toBeGreaterThan(0);
  });

  test("finds the first sample of a window", () => {
    const recording = new Recording(1, 8, 1);
    for (let i = 0; i < 12; i++) recording.push(frameAt(i, [i]));
    expect(recording.time(recording.firstAt(6.5))).toBe(7);
    expect(recording.firstAt(-1)).toBe(0);
    expect(recording.firstAt(99)).toBe(recording.length);
  });

  test("knows the error only where something is desired", () => {
    const recording = new Recording(2);
    recording.push(frameAt(0, [1, 1], [1.5, null]));
    expect(recording.value("error", 0, 0)).toBe(0.5);
    expect(recording.value("error", 1, 0)).toBeNaN();
  });

  test("a copy stays as it was", () => {
    const recording = new Recording(1);
    recording.push(frameAt(0, [1]));
    const copy = recording.copy();
    recording.push(frameAt(1, [2]));
    expect(times(copy)).toEqual([0]);
    expect(copy.value("position", 0, 0)).toBe(1);
  });
});

describe("a table to draw", () => {
  test("has desired and position of each joint in the shown unit, and gaps", () => {
    const recording = new Recording(2);
    recording.push(frameAt(0, [9, 9]));
    recording.push(frameAt(1, [1, 2], [null, 3]));
    const scale = { symbol: "mm", factor: 1000, digits: 1 };
    const lines = [{ joint: joint("b"), index: 1, colour: 0, scale }];
    expect(tableOf(recording, lines, "position", 0.5)).toEqual([[1], [3000], [2000]]);
    const other = [{ joint: joint("a"), index: 0, colour: 0, scale }];
    expect(tableOf(recording, other, "error", 0.5)).toEqual([[1], [null]]);
  });
});

describe("a CSV file", () => {
  const recording = new Recording(2);
  recording.push(frameAt(0.008, [0.1 + 0.2, 1], [0.5]));
  recording.push(frameAt(0.016, [1e-9, 2], [0.5]));
  recording.push(frameAt(0.024, [3, 3], [0.5]));

  test("names every column with its SI unit", () => {
    const columns = [
      { index: 0, joint: joint("elbow") },
      { index: 1, joint: joint('slide "x", left', { type: "prismatic" }) },
    ];
    const [header] = csvOf(recording, columns, 0, 1).split("\n");
    expect(header).toBe(
      "time [s],elbow.position [rad],elbow.desired [rad],elbow.error [rad]," +
        'elbow.velocity [rad/s],elbow.effort [N*m],"slide ""x"", left.position [m]",' +
        '"slide ""x"", left.desired [m]","slide ""x"", left.error [m]",' +
        '"slide ""x"", left.velocity [m/s]","slide ""x"", left.effort [N]"',
    );
  });

  test("has every digit, nothing where nothing is known, and only the window", () => {
    const text = csvOf(recording, [{ index: 1, joint: joint("elbow") }], 0.01, 0.02);
    expect(text.split("\n").slice(1)).toEqual(["0.016,2,,,20,200", ""]);
    const exact = csvOf(recording, [{ index: 0, joint: joint("elbow") }], 0, 0.01);
    const position = 0.1 + 0.2;
    const cells = [0.008, position, 0.5, 0.5 - position, 10 * position, 100 * position];
    expect(exact.split("\n")[1]?.split(",").map(Number)).toEqual(cells);
  });
});

describe("axes", () => {
  test("a limit of effort is seen once half of it is used", () => {
    expect(limitsNear(150, [-10, 74, null])).toEqual([]);
    expect(limitsNear(150, [-10, 76])).toEqual([150]);
    expect(limitsNear(150, [-76, 76])).toEqual([150, -150]);
    expect(limitsNear(null, [1e9])).toEqual([]);
    expect(rangeOf(-10, 76, [150])[1]).toBeGreaterThan(150);
  });

  test("a flat line is not drawn on the edge", () => {
    for (const value of [0, 3, -2]) {
      const [low, high] = rangeOf(value, value);
      expect(low).toBeLessThan(value);
      expect(high).toBeGreaterThan(value);
    }
    const [low, high] = rangeOf(null, null);
    expect(high).toBeGreaterThan(low);
  });

  test("units follow the quantity, the joint and the person", () => {
    expect(scaleOf("position", "revolute", "deg").symbol).toBe("°");
    expect(scaleOf("velocity", "continuous", "rad").symbol).toBe("rad/s");
    expect(scaleOf("velocity", "prismatic", "deg")).toMatchObject({
      symbol: "mm/s",
      factor: 1000,
    });
    expect(scaleOf("effort", "prismatic", "rad").symbol).toBe("N");
    expect(scaleOf("effort", "revolute", "deg").factor).toBe(1);
  });
});

test("a joint that is added gets a colour that no other has, while there are any", () => {
  expect(freeColour([])).toBe(0);
  expect(freeColour([0, 1, 3])).toBe(2);
  expect(freeColour([0, 1, 2, 3, 4, 5])).toBe(0);
  expect(freeColour([0, 1, 2, 3, 4, 5, 0])).toBe(1);
});

test("a legend goes on in the next row when one is full", () => {
  const legend = ["one", "two", "three"].map((text) => ({ colour: "red", text }));
  const places = placesOf(legend, 250, () => 80);
  expect(places.map(({ x, row }) => [x, row])).toEqual([
    [0, 0],
    [120, 0],
    [0, 1],
  ]);
});
