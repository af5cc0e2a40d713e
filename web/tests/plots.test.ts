import { signal } from "@preact/signals";
import { describe, expect, test } from "vitest";
import { type LiveSignal, signalsOf } from "../src/plots/catalogue";
import { csvOf } from "../src/plots/csv";
import { History, type Moment } from "../src/plots/history";
import { placesOf } from "../src/plots/image";
import { parseLayout } from "../src/plots/layout";
import { HistorySource } from "../src/plots/live";
import { matches } from "../src/plots/picker";
import {
  freeColour,
  limitsNear,
  rangeOf,
  scaleOf,
  tickText,
} from "../src/plots/quantities";
import { thinned } from "../src/plots/thinning";
import type { Frame } from "../src/messages";
import type { GripperInfo, ViewInfo } from "../src/protocol";
import { frame, joint, status, view } from "./fixtures";
import { parseUrdf } from "../src/urdf";
import { UR5 } from "./ur5";

function momentAt(time: number, position: number[], more: Partial<Frame> = {}): Moment {
  const desired = position.map(() => null);
  const moving = { velocity: position, effort: position.map((one) => 100 * one) };
  return {
    frame: frame({ time, position, desired, ...moving, ...more }),
    status: null,
    scene: null,
  };
}

function times(history: History): number[] {
  return Array.from({ length: history.length }, (_one, i) => history.time(i));
}

/** A source of the robot of `info`, with moments. */
function sourceOf(info: ViewInfo, moments: Moment[], objects: string[] = []) {
  const source = new HistorySource(signal(signalsOf(info, null, objects)));
  for (const one of moments) source.push(one);
  return source;
}

/** Return the values of a signal at all moments. */
function valuesOf(source: HistorySource, id: string): readonly (number | null)[] {
  return source.read([id], -Infinity, Infinity, Infinity).values[0] ?? [];
}

describe("the history", () => {
  test("keeps the newest moments and forgets the oldest", () => {
    const history = new History(8, 1);
    for (let i = 0; i < 20; i++) history.push(momentAt(i, [i]));
    expect(times(history)).toEqual([12, 13, 14, 15, 16, 17, 18, 19]);
    expect(history.at(0)?.frame.position).toEqual([12]);
  });

  test("is cleared when time goes back", () => {
    const history = new History();
    history.push(momentAt(5, [1]));
    history.push(momentAt(0, [2]));
    expect(times(history)).toEqual([0]);
  });

  test("has one moment of an instant, the newest", () => {
    const history = new History();
    history.push(momentAt(1, [1]));
    history.push(momentAt(2, [2]));
    history.push(momentAt(2, [3]));
    expect(times(history)).toEqual([1, 2]);
    expect(history.at(1)?.frame.position).toEqual([3]);
  });

  test("holds its whole span in slow motion too, and always the newest moment", () => {
    const history = new History(100, 10);
    let time = 0;
    for (let i = 0; i < 5000; i++) {
      time = i * 0.004;
      history.push(momentAt(time, [time]));
      expect(history.time(history.length - 1)).toBe(time);
    }
    expect(time - history.time(0)).toBeGreaterThan(9);
    const steps = times(history).map((one, i, all) => one - (all[i - 1] ?? -1));
    expect(Math.min(...steps)).toBeGreaterThan(0);
  });

  test("finds the first moment of a window", () => {
    const history = new History(8, 1);
    for (let i = 0; i < 12; i++) history.push(momentAt(i, [i]));
    expect(history.time(history.firstAt(6.5))).toBe(7);
    expect(history.firstAt(-1)).toBe(0);
    expect(history.firstAt(99)).toBe(history.length);
  });
});

describe("the signals of a robot", () => {
  test("are its joints, the wrench of its arm, and the simulation", () => {
    const info = view();
    const robots = [
      {
        ...{ name: "arm", title: null, prefix: "", base: "base", gripper: null },
        ...{ joints: ["pan", "lift"], tip: "tool0" },
      },
    ];
    const found = signalsOf({ ...info, robot: { ...info.robot, robots } }, null, []);
    expect([...found.keys()]).toEqual([
      ...["pan", "lift"].flatMap((name) =>
        ["position", "desired", "error", "velocity", "effort"].map(
          (quantity) => `joint/${name}/${quantity}`,
        ),
      ),
      ...["fx", "fy", "fz", "tx", "ty", "tz"].map((axis) => `wrench/arm/${axis}`),
      "simulation/real_time_factor",
      "simulation/late_ticks",
    ]);
    const wrenches = { arm: [1, 2, 3, 4, 5, 6] } as NonNullable<Frame["wrenches"]>;
    const moment = momentAt(0, [0, 0], { wrenches });
    const value = (id: string) => found.get(id)?.value(moment);
    expect(value("wrench/arm/fz")).toBe(3);
    expect(value("wrench/arm/tx")).toBe(4);
    expect(found.get("wrench/arm/fz")?.value(momentAt(0, [0, 0]))).toBeUndefined();
  });

  test("have those of a simulated run where a recording has one, drawn dashed", () => {
    const signals = ["joint/pan/simulated", "joint/pan/simulated_effort"];
    const replay = { file: "a.mcap", start: 0, end: 1, is_complete: true, signals };
    const found = signalsOf({ ...view({ mode: "replay" }), replay }, null, []);
    expect(found.get("joint/pan/position")?.desired).toBe("joint/pan/simulated");
    expect(found.get("joint/pan/effort")?.desired).toBe("joint/pan/simulated_effort");
    expect(found.get("joint/pan/simulated")?.kind).toBe("angle");
    expect(found.get("joint/pan/simulated_effort")?.kind).toBe("torque");
  });

  test("have an error only where something is desired", () => {
    const moments = [momentAt(0, [1, 1], { desired: [1.5, null] })];
    const source = sourceOf(view(), moments);
    expect(valuesOf(source, "joint/pan/error")).toEqual([0.5]);
    expect(valuesOf(source, "joint/lift/error")).toEqual([null]);
  });

  test("have the pose of the tool from the joints, as the chain says", () => {
    const info = view();
    const model = parseUrdf(UR5);
    const names = [...model.parentJoint.values()].flatMap((one) =>
      one.type === "revolute" ? [one.name] : [],
    );
    const robots = [
      {
        ...{ name: "arm", title: null, prefix: "", base: "base_link", gripper: null },
        ...{ joints: names, tip: "tool0" },
      },
    ];
    const joints = names.map((name) => joint(name));
    const found = signalsOf(
      { ...info, robot: { ...info.robot, joints, robots } },
      model,
      [],
    );
    const at = (q: number[]) =>
      ["x", "y", "z"].map((axis) =>
        Number(found.get(`tool/arm/${axis}`)?.value(momentAt(0, q))),
      );
    const home = at(names.map(() => 0));
    const turned = at(
      names.map((name) => (name === "shoulder_pan_joint" ? Math.PI / 2 : 0)),
    );
    // a quarter turn of the base turns the tool about z
    expect(turned[0]).toBeCloseTo(-(home[1] ?? NaN), 9);
    expect(turned[1]).toBeCloseTo(home[0] ?? NaN, 9);
    expect(turned[2]).toBeCloseTo(home[2] ?? NaN, 9);
    expect(Math.hypot(...home)).toBeGreaterThan(0.5);
  });

  test("have opening and force of a gripper from its joint", () => {
    const gripper: GripperInfo = {
      ...{ name: "hand", joint: "lift", max_opening: 0.1 },
      ...{ min_speed: 0, max_speed: 1, min_force: 10, max_force: 100 },
      ...{ pad_offset: 0.05, pad_cos: 0, pad_sin: 0, pad_slope: -1 },
    };
    const info = view();
    const robot = { ...info.robot, grippers: [gripper] };
    const source = sourceOf({ ...info, robot }, [
      momentAt(0, [0, 0.02], { effort: [0, 80] }),
    ]);
    expect(valuesOf(source, "gripper/hand/opening")[0]).toBeCloseTo(0.06, 12);
    expect(valuesOf(source, "gripper/hand/force")[0]).toBeCloseTo(40, 12);
  });

  test("have the pose of an object in the frames of its scene only", () => {
    const objects: Frame["objects"] = [
      [
        [1, 2, 3],
        [Math.SQRT1_2, 0, 0, Math.SQRT1_2],
      ],
    ];
    const shape = { kind: "sphere", radius: 0.1 } as const;
    const cup = { name: "cup", shape, rgba: [1, 1, 1, 1], mass: 1 } as const;
    const scene = {
      type: "scene",
      number: 4,
      objects: [{ ...cup, rgba: [1, 1, 1, 1] }],
    };
    const moment = (number: number) => ({
      ...momentAt(number, [0, 0], { objects, scene_number: number }),
      scene: scene as Moment["scene"],
    });
    const source = sourceOf(view(), [moment(4), moment(5)], ["cup"]);
    expect(valuesOf(source, "object/cup/y")).toEqual([2, null]);
    expect(valuesOf(source, "object/cup/yaw")[0]).toBeCloseTo(Math.PI / 2, 12);
  });

  test("have the real-time factor from the status", () => {
    const moment = {
      ...momentAt(0, [0, 0]),
      status: status({ real_time_factor: 0.5 }),
    };
    expect(valuesOf(sourceOf(view(), [moment]), "simulation/real_time_factor")).toEqual(
      [0.5],
    );
  });

  test("are found by any words", () => {
    const effort = signalsOf(view(), null, []).get("joint/pan/effort");
    if (effort === undefined) throw new Error("no effort");
    expect(matches(effort, "eff pan")).toBe(true);
    expect(matches(effort, "Joint EFFORT")).toBe(true);
    expect(matches(effort, "lift")).toBe(false);
  });
});

describe("a source", () => {
  const moments = [0, 1, 2, 3, 4].map((time) => momentAt(time, [time, 0]));
  const id = "joint/pan/position";

  test("reads a range and one sample on either side", () => {
    const { times, values } = sourceOf(view(), moments).read([id], 1.5, 2.5, Infinity);
    expect(times).toEqual([1, 2, 3]);
    expect(values).toEqual([[1, 2, 3]]);
  });

  test("has exactly the samples of a range for files", async () => {
    const source = sourceOf(view(), moments);
    expect((await source.exact([id, "joint/none/position"], 1, 3)).values).toEqual([
      [1, 2, 3],
      [null, null, null],
    ]);
  });

  test("that is held keeps what it has", () => {
    const source = sourceOf(view(), moments);
    const held = source.held();
    source.push(momentAt(5, [5, 0]));
    source.push(momentAt(0, [9, 0])); // reset
    expect(held.span()).toEqual([0, 4]);
    expect(held.read([id], 0, 9, Infinity).values).toEqual([[0, 1, 2, 3, 4]]);
    expect(source.span()).toEqual([0, 0]);
  });

  test("computes again what another robot's signal of the same name was", () => {
    const signals = signal<ReadonlyMap<string, LiveSignal>>(
      signalsOf(view(), null, []),
    );
    const source = new HistorySource(signals);
    source.push(momentAt(0, [1, 2]));
    expect(valuesOf(source, id)).toEqual([1]);
    const info = view();
    const joints = [joint("lift"), joint("pan")];
    signals.value = signalsOf({ ...info, robot: { ...info.robot, joints } }, null, []);
    expect(valuesOf(source, id)).toEqual([2]);
  });
});

describe("thinned samples", () => {
  test("keep every peak", () => {
    const times = Array.from({ length: 1000 }, (_one, i) => i);
    const row = times.map((i) => (i === 357 ? 9 : i === 612 ? -9 : Math.sin(i / 50)));
    const few = thinned({ times, values: [row] }, 100);
    expect(few.times.length).toBeLessThanOrEqual(100);
    expect(Math.max(...few.values.flat().map(Number))).toBe(9);
    expect(Math.min(...few.values.flat().map(Number))).toBe(-9);
    expect([...few.times].sort((a, b) => a - b)).toEqual(few.times);
    expect([few.times[0], few.times.at(-1)]).toEqual([0, 999]);
  });

  test("keep gaps, and what is short", () => {
    const times = Array.from({ length: 100 }, (_one, i) => i);
    const row = times.map((i) => (i < 50 ? null : i));
    const few = thinned({ times, values: [row] }, 20);
    expect(few.values[0]?.[0]).toBeNull();
    expect(few.values[0]?.at(-1)).toBe(99);
    const short = { times: [1, 2], values: [[1, null]] };
    expect(thinned(short, 20)).toBe(short);
  });
});

describe("a CSV file", () => {
  test("names every column with its SI unit", () => {
    const info = view();
    const joints = [joint("elbow"), joint('slide "x", left', { type: "prismatic" })];
    const found = signalsOf({ ...info, robot: { ...info.robot, joints } }, null, []);
    const signals = [...found.values()].filter(({ quantity }) => quantity === "effort");
    expect(csvOf({ times: [], values: [[], []] }, signals)).toBe(
      'time [s],elbow.effort [N*m],"slide ""x"", left.effort [N]"\n',
    );
  });

  test("has every digit, and nothing where nothing is known", () => {
    const exact = 0.1 + 0.2;
    const text = csvOf(
      {
        times: [0.008, 0.016],
        values: [
          [exact, null],
          [null, -1e-9],
        ],
      },
      [],
    );
    expect(text.split("\n").slice(1)).toEqual([
      `0.008,${String(exact)},`,
      "0.016,,-1e-9",
      "",
    ]);
  });
});

describe("axes", () => {
  test("a limit of effort is seen once half of it is used", () => {
    expect(limitsNear(150, [-10, 74, null])).toEqual([]);
    expect(limitsNear(150, [-10, 76])).toEqual([150]);
    expect(limitsNear(150, [-76, 76])).toEqual([150, -150]);
    expect(limitsNear(undefined, [1e9])).toEqual([]);
    expect(rangeOf(-10, 76, 2, [150])[1]).toBeGreaterThan(150);
  });

  test("a flat line is not drawn on the edge", () => {
    for (const value of [0, 3, -2]) {
      const [low, high] = rangeOf(value, value, 3);
      expect(low).toBeLessThan(value);
      expect(high).toBeGreaterThan(value);
    }
    const [low, high] = rangeOf(null, null, 3);
    expect(high).toBeGreaterThan(low);
  });

  test("noise is not enlarged beyond what is shown in numbers", () => {
    const [low, high] = rangeOf(1.0, 1.0001, 3);
    expect(high - low).toBeGreaterThan(0.01);
    expect(rangeOf(1.0, 1.1, 3)[1]).toBeCloseTo(1.106);
  });

  test("neighbouring ticks have different texts", () => {
    expect([0, 0.0005, 0.001].map((tick) => tickText(tick, 0.0005))).toEqual([
      "0",
      "0.0005",
      "0.001",
    ]);
    expect([-0, 0.25, 0.5].map((tick) => tickText(tick, 0.25))).toEqual([
      "0",
      "0.25",
      "0.5",
    ]);
    expect([0, 20, 40].map((tick) => tickText(tick, 20))).toEqual(["0", "20", "40"]);
  });

  test("units follow the quantity and the user", () => {
    expect(scaleOf("angle", "deg").symbol).toBe("°");
    expect(scaleOf("angular-velocity", "rad").symbol).toBe("rad/s");
    expect(scaleOf("velocity", "deg")).toMatchObject({ symbol: "mm/s", factor: 1000 });
    expect(scaleOf("torque", "deg").factor).toBe(1);
  });
});

describe("a stored layout", () => {
  test("is what was stored", () => {
    const layout = [[{ id: "joint/pan/position", colour: 5 }], []];
    expect(parseLayout(JSON.stringify(layout))).toEqual(layout);
  });

  test.each(["", "{", "[]", "3", '[{"id":"x"}]', '[[{"id":3,"colour":0}]]'])(
    "that is damaged counts as none: %s",
    (text) => {
      expect(parseLayout(text)).toBeUndefined();
    },
  );

  test("with a colour that does not exist counts as none", () => {
    expect(parseLayout('[[{"id":"x","colour":6}]]')).toBeUndefined();
    expect(parseLayout('[[{"id":"x","colour":0.5}]]')).toBeUndefined();
  });
});

test("a signal that is added gets a colour that no other has, while there are any", () => {
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
