import { describe, expect, it } from "vitest";
import { fixed } from "../src/ui/number-field";
import { share, stepped } from "../src/ui/slider";
import {
  DEGREES,
  MILLIMETRES,
  parseQuantity,
  RADIANS,
  spanOf,
  unitOf,
} from "../src/units";
import { joint } from "./fixtures";

describe("units", () => {
  it("shows angles as a person likes, and lengths in millimetres", () => {
    expect(unitOf("revolute", "deg")).toBe(DEGREES);
    expect(unitOf("continuous", "rad")).toBe(RADIANS);
    expect(unitOf("prismatic", "deg")).toBe(MILLIMETRES);
    expect(Math.PI * DEGREES.factor).toBeCloseTo(180);
  });

  it("gives unlimited joints two turns to each side", () => {
    const [lower, upper] = spanOf(joint("wheel", { lower: null, upper: null }));
    expect([lower, upper]).toEqual([-2 * Math.PI, 2 * Math.PI]);
  });

  it.each([
    ["1.5", 1.5],
    [" -0,25 ", -0.25],
    ["−3", -3],
    [".5", 0.5],
    ["1e-3", 0.001],
  ])("reads %s", (text, value) => {
    expect(parseQuantity(text, "rad")).toBe(value);
  });

  it.each([
    ["90deg", "rad", Math.PI / 2],
    ["90 °", "rad", Math.PI / 2],
    ["1.5 rad", "°", 85.943669],
    ["45", "°", 45],
    ["4cm", "mm", 40],
    ["0.04m", "mm", 40],
    ["1e-1 m/s", "mm/s", 100],
    ["250 g", "kg", 0.25],
    ["60N", "N", 60],
  ])("reads %s as %s", (text, unit, value) => {
    expect(parseQuantity(text, unit)).toBeCloseTo(value, 5);
  });

  it.each(["", "-", "1.2.3", "1m", "1 2", "deg", "NaN", "Infinity", "0x10"])(
    "refuses %j",
    (text) => {
      expect(parseQuantity(text, "rad")).toBeUndefined();
    },
  );

  it("writes no negative zero", () => {
    expect(fixed(-0.0001, 2)).toBe("0.00");
    expect(fixed(-0.01, 2)).toBe("-0.01");
  });
});

describe("a slider", () => {
  const at = { value: 0.5, min: -1, max: 1, step: 0.01 };

  it.each([
    ["ArrowUp", false, 0.51],
    ["ArrowDown", false, 0.49],
    ["ArrowUp", true, 0.6],
    ["PageDown", false, 0.4],
    ["Home", false, -1],
    ["End", false, 1],
  ])("goes by %s (Shift: %s) to %f", (key, shiftKey, value) => {
    expect(stepped({ key, shiftKey }, at)).toBeCloseTo(value);
  });

  it("stays within its ends and leaves other keys alone", () => {
    expect(stepped({ key: "ArrowUp", shiftKey: true }, { ...at, value: 0.99 })).toBe(1);
    expect(stepped({ key: "Tab", shiftKey: false }, at)).toBeUndefined();
  });

  it("has a place for every value", () => {
    expect([share(0, -1, 1), share(9, -1, 1), share(1, 1, 1)]).toEqual([0.5, 1, 0]);
  });
});
