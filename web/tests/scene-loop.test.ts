import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Loop } from "../src/scene/loop";

beforeEach(() => {
  vi.useFakeTimers({
    toFake: ["requestAnimationFrame", "cancelAnimationFrame", "performance"],
  });
});

afterEach(() => {
  vi.useRealTimers();
});

test("draws once for what changed once, and then asks for nothing", () => {
  const draw = vi.fn();
  const loop = new Loop({ step: () => false, draw }, 0);
  loop.invalidate();
  loop.invalidate();
  vi.advanceTimersByTime(1000);
  expect(draw).toHaveBeenCalledTimes(1);
  expect(vi.getTimerCount()).toBe(0);
});

test("looks at every display frame while something moves, but draws only changes", () => {
  const draw = vi.fn();
  let left = 10;
  const step = vi.fn(() => --left > 0);
  const loop = new Loop({ step, draw }, 0);
  loop.wake();
  vi.advanceTimersByTime(1000);
  expect(step).toHaveBeenCalledTimes(10);
  expect(draw).not.toHaveBeenCalled();
});

test("draws no more often than it may", () => {
  const draw = vi.fn();
  const scenery = {
    step: () => {
      loop.invalidate();
      return true;
    },
    draw,
  };
  const loop = new Loop(scenery, 100);
  loop.wake();
  vi.advanceTimersByTime(1000);
  expect(draw.mock.calls.length).toBeGreaterThan(7);
  expect(draw.mock.calls.length).toBeLessThan(12);
  loop.stop();
});

test("once stopped it never draws again", () => {
  const draw = vi.fn();
  const loop = new Loop({ step: () => true, draw }, 0);
  loop.invalidate();
  loop.stop();
  loop.invalidate();
  vi.advanceTimersByTime(1000);
  expect(draw).not.toHaveBeenCalled();
});
