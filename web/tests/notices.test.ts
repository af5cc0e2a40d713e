import { describe, expect, it, vi } from "vitest";
import { report, showNotice, toasts } from "../src/notices";
import type { Notice } from "../src/protocol";
import { notices } from "../src/store";
import { FakeSocket, view } from "./fixtures";
import { useFakeServer } from "./setup";

const notice = (severity: Notice["severity"], text: string): Notice => ({
  type: "notice",
  number: 1,
  wall_time: 0,
  time: 0,
  severity,
  code: "log",
  text,
});
const texts = () => toasts.value.map((toast) => toast.text);

describe("notices", () => {
  useFakeServer();

  it("stay as errors, and pass as warnings", () => {
    report("error", "broken");
    report("warning", "careful");
    vi.advanceTimersByTime(60_000);
    expect(texts()).toEqual(["broken"]);
    expect(notices.value).toHaveLength(2);
  });

  it("are merged when repeated", () => {
    report("error", "again");
    report("error", "again");
    expect(toasts.value.map((toast) => toast.count)).toEqual([2]);
  });

  it("are merged when only their numbers differ, and show the newest", () => {
    report("error", "position 3.2 is beyond 3.14");
    report("error", "position 3.25 is beyond 3.14");
    expect(texts()).toEqual(["position 3.25 is beyond 3.14"]);
  });

  it("are at most four, of which errors stay longest", () => {
    report("error", "first");
    for (const text of ["a", "b", "c", "d", "e"]) report("warning", text);
    expect(texts()).toEqual(["first", "c", "d", "e"]);
  });

  it("that only inform are in the log alone", () => {
    showNotice(notice("info", "arrived"));
    expect(texts()).toEqual([]);
    expect(notices.value.map((one) => one.text)).toEqual(["arrived"]);
  });

  it("that the page tells elsewhere are in the log alone", () => {
    const codes = ["overrun", "stall", "emergency_stop"] as const;
    for (const code of codes) showNotice({ ...notice("warning", code), code });
    expect(texts()).toEqual([]);
    expect(notices.value.map((one) => one.text)).toEqual(codes);
  });

  it("of before this page are said in one sentence", () => {
    const before = ["a", "b", "c", "d", "e"].map((text) => notice("warning", text));
    FakeSocket.newest.say(view({ notices: before }));
    expect(toasts.value).toHaveLength(1);
    expect(texts()[0]).toContain("5");
    expect(notices.value).toHaveLength(5);
  });
});
