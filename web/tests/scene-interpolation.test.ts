import { describe, expect, test } from "vitest";
import type { Frame } from "../src/messages";
import { Interpolator, type Pose } from "../src/scene/interpolation";
import { frame } from "./fixtures";

const TICK = 1000 / 60;

function frameAt(time: number, position: number[], objects: unknown[] = []): Frame {
  return frame({ time, position, objects: objects as Frame["objects"] });
}

function empty(): Pose {
  return { time: 0, values: new Float64Array(0), scene: 0 };
}

/** A joint that moves evenly: its position is its simulated time. */
function play(interpolator: Interpolator, from: number, count: number, speed = 1) {
  for (let i = from; i < from + count; i++) {
    const time = (speed * i * TICK) / 1000;
    interpolator.push(frameAt(time, [time]), i * TICK);
  }
}

describe("between frames", () => {
  test("an even motion is shown as even, one and a half frames late", () => {
    const interpolator = new Interpolator();
    play(interpolator, 0, 40);
    const pose = empty();
    const newest = 39 * TICK;
    for (const past of [0, 3, 7, 11]) {
      expect(interpolator.sample(newest + past, pose)).toBe(false);
      const wanted = (newest + past - 1.5 * TICK) / 1000;
      expect(pose.values[0]).toBeCloseTo(wanted, 6);
      expect(pose.time).toBeCloseTo(wanted, 6);
    }
  });

  test("frames that arrive unevenly are shown evenly all the same", () => {
    const interpolator = new Interpolator();
    const pose = empty();
    const shown: number[] = [];
    // every other frame is eight milliseconds late
    for (let i = 0; i < 120; i++) {
      const arrival = i * TICK + (i % 2) * 8;
      interpolator.push(frameAt((i * TICK) / 1000, [(i * TICK) / 1000]), arrival);
      interpolator.sample((i + 0.55) * TICK, pose);
      shown.push(pose.values[0] ?? NaN);
    }
    const steps = shown
      .slice(60)
      .map((value, i, all) => value - (all[i - 1] ?? value - TICK / 1000));
    expect(Math.min(...steps)).toBeGreaterThan(0.8 * (TICK / 1000));
    expect(Math.max(...steps)).toBeLessThan(1.2 * (TICK / 1000));
  });

  test("what is shown stops at the newest frame, and says so", () => {
    const interpolator = new Interpolator();
    play(interpolator, 0, 40);
    const pose = empty();
    expect(interpolator.sample(39 * TICK + 1000, pose)).toBe(true);
    expect(pose.values[0]).toBe((39 * TICK) / 1000);
  });

  test("nothing is shown twice: time never goes back on its own", () => {
    const interpolator = new Interpolator();
    const pose = empty();
    play(interpolator, 0, 40);
    interpolator.sample(39 * TICK + 20, pose);
    const before = pose.time;
    // from now on a tenth of the speed
    for (let i = 1; i < 40; i++) {
      const time = (39 * TICK + (i * TICK) / 10) / 1000;
      interpolator.push(frameAt(time, [time]), (39 + i) * TICK);
      interpolator.sample((39 + i) * TICK, pose);
      expect(pose.time).toBeGreaterThanOrEqual(before);
    }
  });

  test.each([0.1, 2, 50])(
    "at %s times the speed it is one and a half frames late too",
    (speed) => {
      const interpolator = new Interpolator();
      play(interpolator, 0, 40, speed);
      const pose = empty();
      interpolator.sample(39 * TICK, pose);
      expect(pose.time).toBeCloseTo((speed * 37.5 * TICK) / 1000, 5);
    },
  );
});

describe("when the flow of time changes", () => {
  test("a reset snaps to the new beginning", () => {
    const interpolator = new Interpolator();
    play(interpolator, 0, 40);
    interpolator.push(frameAt(0, [-7]), 40 * TICK);
    const pose = empty();
    expect(interpolator.sample(40 * TICK, pose)).toBe(true);
    expect(pose.values[0]).toBe(-7);
  });

  test("after a gap nothing sweeps across it", () => {
    const interpolator = new Interpolator();
    play(interpolator, 0, 40);
    interpolator.push(frameAt(9, [9]), 40 * TICK + 8000);
    const pose = empty();
    interpolator.sample(40 * TICK + 8000, pose);
    expect(pose.values[0]).toBe(9);
  });

  test("paused, a frame of the same time replaces what is shown", () => {
    const interpolator = new Interpolator();
    interpolator.push(frameAt(1, [0]), 0);
    interpolator.push(frameAt(1, [5]), 5000);
    const pose = empty();
    expect(interpolator.sample(5000, pose)).toBe(true);
    expect(pose.values[0]).toBe(5);
  });

  test("a new speed is followed at once", () => {
    const interpolator = new Interpolator();
    play(interpolator, 0, 40);
    const start = 39 * TICK;
    const pose = empty();
    for (let i = 1; i <= 20; i++) {
      const time = (start + 20 * i * TICK) / 1000;
      interpolator.push(frameAt(time, [time]), start + i * TICK);
    }
    interpolator.sample(start + 20 * TICK, pose);
    expect(pose.time).toBeCloseTo((start + 20 * 18.5 * TICK) / 1000, 2);
  });

  test("without a frame there is nothing to draw", () => {
    expect(new Interpolator().sample(0, empty())).toBe(true);
  });
});

describe("poses of objects", () => {
  test("follow the joints, position and then quaternion", () => {
    const interpolator = new Interpolator();
    interpolator.push(
      frameAt(
        0,
        [4],
        [
          [
            [1, 2, 3],
            [1, 0, 0, 0],
          ],
        ],
      ),
      0,
    );
    const pose = empty();
    interpolator.sample(0, pose);
    expect([...pose.values]).toEqual([4, 1, 2, 3, 1, 0, 0, 0]);
  });

  test("a quaternion and its negative are one rotation: nothing spins between them", () => {
    const interpolator = new Interpolator();
    const pose = empty();
    for (let i = 0; i < 10; i++) {
      const sign = i % 2 ? -1 : 1;
      const object = [
        [0, 0, 0],
        [sign * 0.6, 0, 0, sign * 0.8],
      ];
      interpolator.push(frameAt((i * TICK) / 1000, [0], [object]), i * TICK);
      interpolator.sample(i * TICK, pose);
      const quaternion = [...pose.values.slice(4)];
      expect(quaternion.map((one) => Number(one.toFixed(9)))).toEqual([0.6, 0, 0, 0.8]);
    }
  });

  test("nothing flies from where one was to where another, which came for it, is", () => {
    const interpolator = new Interpolator();
    const pose = empty();
    const at = (x: number): Frame["objects"] => [
      [
        [x, 0, 0],
        [1, 0, 0, 0],
      ],
    ];
    for (let i = 0; i < 40; i++) {
      const time = (i * TICK) / 1000;
      const [x, scene] = i < 39 ? [1, 0] : [5, 1];
      interpolator.push(
        frame({ time, position: [time], objects: at(x), scene_number: scene }),
        i * TICK,
      );
    }
    interpolator.sample(40 * TICK, pose);
    expect(pose.scene).toBe(1);
    expect(pose.values[1]).toBe(5);
    // while the joints move as evenly as ever
    expect(pose.values[0]).toBeCloseTo((38.5 * TICK) / 1000, 6);
    interpolator.sample(40.6 * TICK, pose);
    expect(pose.values[0]).toBeCloseTo(0.039 * TICK, 6);
  });
});
