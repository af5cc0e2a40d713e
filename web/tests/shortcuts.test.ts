import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { onShortcut, register } from "../src/shortcuts";

describe("shortcuts", () => {
  let removals: (() => void)[] = [];
  beforeEach(() => {
    document.addEventListener("keydown", onShortcut);
  });
  afterEach(() => {
    document.removeEventListener("keydown", onShortcut);
    for (const remove of removals) remove();
    removals = [];
    document.body.innerHTML = "";
  });

  function press(key: string, init: KeyboardEventInit = {}, target = document.body) {
    const event = new KeyboardEvent("keydown", {
      key,
      bubbles: true,
      cancelable: true,
      ...init,
    });
    target.dispatchEvent(event);
    return event;
  }

  it("run what is registered for the key, until it is removed", () => {
    const run = vi.fn();
    const remove = register({
      keys: ["Ctrl+z"],
      text: "shortcuts.help",
      group: "scene",
      run,
    });
    expect(press("z").defaultPrevented).toBe(false);
    expect(press("z", { ctrlKey: true }).defaultPrevented).toBe(true);
    remove();
    press("z", { ctrlKey: true });
    expect(run).toHaveBeenCalledTimes(1);
  });

  it("tell Shift apart for letters and named keys, not for signs", () => {
    const run = vi.fn();
    removals.push(
      register({
        keys: ["Shift+Delete", "?", "Ctrl+Shift+z"],
        text: "shortcuts.help",
        group: "scene",
        run,
      }),
    );
    press("Delete");
    press("Z", { ctrlKey: true });
    expect(run).toHaveBeenCalledTimes(0);
    press("Delete", { shiftKey: true });
    press("?", { shiftKey: true });
    press("Z", { ctrlKey: true, shiftKey: true });
    expect(run).toHaveBeenCalledTimes(3);
  });

  it("leave the keys of text fields alone, and wait for their condition", () => {
    const run = vi.fn();
    let applies = false;
    removals.push(
      register({
        keys: ["a"],
        text: "shortcuts.help",
        group: "scene",
        run,
        when: () => applies,
      }),
    );
    const field = document.createElement("input");
    document.body.append(field);
    press("a");
    applies = true;
    press("a", {}, field);
    expect(run).toHaveBeenCalledTimes(0);
    press("a");
    expect(run).toHaveBeenCalledTimes(1);
  });
});
