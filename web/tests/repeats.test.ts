import { describe, expect, it } from "vitest";
import type { Notice } from "../src/protocol";
import { gathered } from "../src/repeats";

let number = 0;

function notice(wall_time: number, changes: Partial<Notice> = {}): Notice {
  number += 1;
  return {
    type: "notice",
    number,
    wall_time,
    time: wall_time,
    severity: "info",
    code: "goal_succeeded",
    text: "arm: goal succeeded",
    ...changes,
  };
}
const behind = (at: number, ticks: number) =>
  notice(at, {
    severity: "warning",
    code: "overrun",
    text: `the simulation falls behind: ${String(ticks)} late ticks in a second`,
  });
const keepsUp = (at: number) =>
  notice(at, { code: "overrun", text: "the simulation keeps up again" });

const shown = (notices: readonly Notice[]) =>
  gathered(notices).map(({ notice, count }) => [notice.wall_time, count]);

describe("repeated notices", () => {
  it("of a machine that falls behind again and again are one, whatever comes between", () => {
    const log = [behind(0, 9), keepsUp(1), notice(2), behind(3, 8), keepsUp(4)];
    expect(shown(log)).toEqual([
      [2, 1],
      [4, 4],
    ]);
  });

  it("are two, if it kept up for a minute", () => {
    expect(shown([behind(0, 9), keepsUp(1), behind(100, 9)])).toEqual([
      [1, 2],
      [100, 1],
    ]);
  });

  it("are one in a row only", () => {
    const other = notice(2, { text: "hand: goal succeeded" });
    expect(shown([notice(0), notice(1), other, notice(3)])).toEqual([
      [1, 2],
      [2, 1],
      [3, 1],
    ]);
  });
});
