import { beforeEach, describe, expect, it, vi } from "vitest";
import { disable, enable, endReason, isDriving, watchDriving } from "../src/driving";
import { frames, shown } from "../src/frames";
import type { Frame } from "../src/messages";
import type { Notice } from "../src/protocol";
import * as store from "../src/store";
import { History } from "../src/timeline/history";
import { kindOf, merged, neighbour } from "../src/timeline/markers";
import { Past } from "../src/timeline/past";
import { FakeSocket, frame, status, view } from "./fixtures";
import { useFakeServer } from "./setup";

const at = (time: number): Frame => frame({ time, position: [time, -time] });

function notice(changes: Partial<Notice>): Notice {
  return {
    type: "notice",
    number: 1,
    wall_time: 0,
    time: 1,
    severity: "info",
    code: "goal_succeeded",
    text: "arm: goal succeeded",
    ...changes,
  };
}

describe("the history", () => {
  it("returns what was last before a time", () => {
    const history = new History();
    for (let i = 0; i <= 10; i++) history.push(at(i / 10), null, 100 * i);
    expect([history.start, history.end]).toEqual([0, 1]);
    expect(history.moment(0.55)?.frame.time).toBe(0.5);
    expect(history.moment(-1)?.frame.time).toBe(0);
    expect(history.moment(9)?.frame.time).toBe(1);
  });

  it("keeps thirty-two frames a second, and always the newest", () => {
    const history = new History();
    for (let i = 0; i <= 600; i++) history.push(at(i / 60), null, (1000 * i) / 60);
    expect(history.length).toBeGreaterThan(250);
    expect(history.length).toBeLessThan(330);
    expect(history.moment(Infinity)?.frame.time).toBe(10);
  });

  it("forgets what is older than its span, and what does not fit", () => {
    const short = new History(1000);
    for (let i = 0; i <= 100; i++) short.push(at(i / 10), null, 100 * i);
    expect(short.start).toBeCloseTo(9);
    const small = new History(Infinity, 160); // 16 numbers a frame
    for (let i = 0; i <= 5000; i++) small.push(at(i / 10), null, 100 * i);
    expect(small.length).toBe(10);
    expect(small.start).toBeCloseTo(499.1);
  });

  it("goes on when a reset sets the time back", () => {
    const history = new History();
    for (const time of [0, 1, 2]) history.push(at(time), null, 1000 * time);
    history.push(at(0), null, 3000);
    history.push(at(1), null, 4000);
    expect(history.end).toBe(3);
    expect(history.moment(1.5)?.frame.time).toBe(1);
    expect(history.moment(3)?.frame.time).toBe(1);
    expect(history.placeOf(1)).toBe(3);
  });

  it("keeps one frame of a pause", () => {
    const history = new History();
    for (let i = 0; i < 50; i++) history.push(at(1), null, 200 * i);
    expect(history.length).toBeLessThanOrEqual(2);
  });
});

describe("marks", () => {
  it("are made of what concerns an instant", () => {
    expect(kindOf(notice({}))).toBe("goal");
    expect(kindOf(notice({ code: "stall", severity: "warning" }))).toBe("warning");
    expect(kindOf(notice({ code: "contact" }))).toBe("contact");
    expect(kindOf(notice({ code: "reset" }))).toBe("event");
    expect(kindOf(notice({ time: null }))).toBeNull();
    expect(kindOf(notice({ code: "lint", severity: "warning" }))).toBeNull();
  });

  const goal = (at: number) => ({ at, kind: "goal" as const, text: `goal ${at}` });

  it("are joined where they cannot be told apart, the most severe on top", () => {
    const near = { at: 1.001, kind: "error" as const, text: "fault" };
    const [first, second, ...rest] = merged([goal(1), near, goal(5)], 0, 10);
    expect(first).toEqual({ at: 1, kind: "error", text: "goal 1\nfault" });
    expect(second?.at).toBe(5);
    expect(rest).toEqual([]);
    expect(merged([goal(1), goal(5)], 2, 10)).toHaveLength(1);
  });

  it("lead from one to the next, and back", () => {
    const all = [goal(1), goal(2), goal(3)];
    expect(neighbour(all, 2, 1)?.at).toBe(3);
    expect(neighbour(all, 2, -1)?.at).toBe(1);
    expect(neighbour(all, 3, 1)).toBeUndefined();
  });
});

describe("scrolling back", () => {
  useFakeServer();
  let past: Past;

  beforeEach(() => {
    past = new Past();
    const end = past.watch();
    const socket = FakeSocket.newest;
    socket.say(view());
    socket.say(status());
    for (let i = 0; i <= 100; i++) {
      past.history.push(at(i / 10), store.scene.peek(), 100 * i);
    }
    return end;
  });

  it("shows the past while frames arrive, and the present again", () => {
    past.seek(5.05);
    FakeSocket.newest.say(at(10.1));
    expect(shown.latest?.time).toBe(5);
    expect(shown.isPast.value).toBe(true);
    expect(frames.latest?.time).toBe(10.1);
    past.goLive();
    expect(shown.latest?.time).toBe(10.1);
    expect(shown.isPast.value).toBe(false);
  });

  it("rests when it has played to the present", async () => {
    past.seek(9.9);
    past.play(true);
    await vi.advanceTimersByTimeAsync(1000);
    expect(shown.isPast.value).toBe(false);
    const asked = vi.spyOn(globalThis, "requestAnimationFrame");
    await vi.advanceTimersByTimeAsync(1000);
    expect(asked).not.toHaveBeenCalled();
  });

  it("is at the present at the end of the line", () => {
    past.seek(5);
    past.seek(Infinity);
    expect(shown.isPast.value).toBe(false);
    expect(past.isPlaying.value).toBe(true);
  });

  it("shows the objects of that time", () => {
    past.history.clear();
    store.scene.value = { type: "scene", number: 1, objects: [] };
    FakeSocket.newest.say(at(20));
    past.history.push(at(21), store.scene.value, 21_000);
    store.scene.value = { type: "scene", number: 2, objects: [] };
    past.history.push(at(22), store.scene.value, 22_000);
    past.seek(21);
    expect(store.shownScene.value?.number).toBe(1);
    past.goLive();
    expect(store.shownScene.value?.number).toBe(2);
  });

  it("ends driving", () => {
    const end = watchDriving();
    enable();
    expect(isDriving.value).toBe(true);
    past.seek(5);
    expect([isDriving.value, endReason.value]).toEqual([false, "past"]);
    disable();
    end();
  });

  it("marks what happens", () => {
    const socket = FakeSocket.newest;
    socket.say(notice({ number: 7, time: 4.5 }));
    socket.say(notice({ number: 8, time: 6, severity: "warning", code: "stall" }));
    const found = past.markers.value.map(({ at, kind }) => [at, kind]);
    expect(found).toEqual([
      [4.5, "goal"],
      [6, "warning"],
    ]);
  });

  it("marks a spell in which the simulation falls behind once", () => {
    const overrun = { code: "overrun", severity: "warning" } as const;
    for (const at of [1, 2, 3, 4, 5]) {
      const changes = { number: at, time: at, wall_time: 10 * at };
      FakeSocket.newest.say(notice({ ...changes, ...overrun }));
    }
    expect(past.markers.value.map(({ at }) => at)).toEqual([1]);
  });

  it("marks that a gripper meets something", () => {
    const gripper = (motion: "moving" | "holding_inside") =>
      status({
        grippers: [{ name: "hand", opening: 0.02, motion, gobj: 0, width: null }],
      });
    FakeSocket.newest.say(gripper("moving"));
    FakeSocket.newest.say(gripper("holding_inside"));
    FakeSocket.newest.say(gripper("holding_inside"));
    expect(past.markers.value.map(({ kind }) => kind)).toEqual(["contact"]);
  });

  it("forgets the past of another server", () => {
    past.seek(5);
    FakeSocket.newest.say(view());
    expect(past.history.length).toBe(0);
    expect(shown.isPast.value).toBe(false);
  });
});
