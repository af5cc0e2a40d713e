import { beforeEach, describe, expect, it, vi } from "vitest";
import { start as beginning } from "../src/program/approach";
import { check, checkProgram, isChecking } from "../src/program/checking";
import { readDraft } from "../src/program/draft";
import { add, EMPTY, isChanged, noteSaved, open, program } from "../src/program/editor";
import { renameSaved, save } from "../src/program/files";
import { runningStep, start } from "../src/program/running";
import * as store from "../src/store";
import { FakeSocket, status, view } from "./fixtures";
import { useFakeServer } from "./setup";

const NOTE = { kind: "comment", text: "a" } as const;
const STILL = { joint_names: [], times: [], positions: [], points: [], steps: [] };
const FINE = { problems: [], warnings: [], motion: STILL };

const settle = () => vi.advanceTimersByTimeAsync(1);

/** Let the server carry out the last request of a method. */
async function answer(method: string, result?: unknown): Promise<void> {
  await settle();
  const id = FakeSocket.newest.sent.filter((one) => one.method === method).at(-1)?.id;
  FakeSocket.newest.sayText(JSON.stringify({ type: "reply", id, result }));
  await settle();
}

describe("the draft of a program", () => {
  useFakeServer();
  const drafted = (draft: unknown) => {
    localStorage.setItem("tool0.program", JSON.stringify(draft));
    return readDraft();
  };

  it("is what was edited last", () => {
    const loop = { kind: "loop", times: 2, steps: [NOTE] };
    expect(drafted({ name: "p", steps: [loop] })?.steps).toEqual([loop]);
  });

  it.each([
    null,
    [],
    { name: "p" },
    { name: "p", steps: [null] },
    { name: "p", steps: [{ kind: "from the future" }] },
    { name: "p", steps: [{ kind: "toString" }] },
    { name: "p", steps: [{ kind: "until", distance: 0.1 }] },
    { name: "p", steps: [{ kind: "loop", steps: [{ kind: "gripper" }] }] },
  ])("is nothing where it is of another version: %j", (draft) => {
    expect(drafted(draft)).toBeNull();
  });
});

describe("a program", () => {
  useFakeServer();
  beforeEach(() => {
    FakeSocket.newest.say(view());
  });

  it("stays changed when its file is renamed", async () => {
    open({ name: "p", steps: [NOTE] }, true);
    add(NOTE);
    const renamed = renameSaved("p", "q");
    await answer("rename_program");
    await answer("list_programs", []);
    await renamed;
    expect([program.value.name, isChanged.value]).toEqual(["q", true]);
    noteSaved(program.value);
    const again = renameSaved("q", "r");
    await answer("rename_program");
    await answer("list_programs", []);
    await again;
    expect([program.value.name, isChanged.value]).toEqual(["r", false]);
  });

  it("stays changed when it is edited while it is saved", async () => {
    open({ name: "p", steps: [NOTE] }, false);
    const saved = save();
    add(NOTE);
    await answer("save_program");
    await answer("list_programs", []);
    await saved;
    expect(isChanged.value).toBe(true);
  });

  it("is not what was checked, if it was edited meanwhile", async () => {
    open({ name: "p", steps: [NOTE] }, false);
    const checked = checkProgram(program.peek());
    add(NOTE);
    expect(isChecking.value).toBe(false);
    await answer("check_program", FINE);
    expect(await checked).toBe(false);
    expect(check.value).toBeNull();
    const again = checkProgram(program.peek());
    await answer("check_program", FINE);
    expect(await again).toBe(true);
    expect(check.value).toEqual(FINE);
  });

  it("shows the running step as long as it is the one that runs", async () => {
    open({ name: "p", steps: [NOTE] }, false);
    const begun = start();
    await answer("check_program", FINE);
    await answer("run_program");
    await begun;
    const run = { run: 1, program: "p", arm: "arm", state: "running", step: [1] };
    store.status.value = { ...status(), programs: [run as never] };
    expect(runningStep.value).toEqual([1]);
    add(NOTE);
    expect(runningStep.value).toBeNull();
    open(EMPTY, false);
  });

  it("that begins elsewhere is not run without a question", async () => {
    const move = { kind: "move_joint", named_pose: "home" } as const;
    const motion = { ...STILL, joint_names: ["pan"], times: [0, 1] };
    open({ name: "p", steps: [move] }, false);
    const begun = start();
    await answer("check_program", {
      ...FINE,
      motion: { ...motion, positions: [[0], [1]], steps: [[1], [1]] },
    });
    await begun;
    expect(FakeSocket.newest.sentOf("run_program")).toEqual([]);
    expect(beginning.value).toEqual({ pan: 1 });
    open(EMPTY, false);
    expect(beginning.value).toBeNull();
  });

  it("that is edited during its check is not run", async () => {
    open({ name: "p", steps: [NOTE] }, false);
    const begun = start();
    add(NOTE);
    await answer("check_program", FINE);
    await begun;
    expect(FakeSocket.newest.sentOf("run_program")).toEqual([]);
    open(EMPTY, false);
  });
});
