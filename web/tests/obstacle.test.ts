import { describe, expect, it } from "vitest";
import { speak } from "../src/i18n";
import { advice, obstacle } from "../src/panels/obstacle";
import { controller } from "./fixtures";

describe("what keeps sliders from driving", () => {
  it.each([
    [{}, null],
    [{ role: "reader" }, "moves no joint"],
    [{ role: "command", type: "effort_controllers/JointGroup" }, "JointGroup"],
    [{ state: "unloaded" }, "not loaded"],
    [{ state: "stopped" }, "not running"],
    [{ undrivable: "no limits" }, "no limits"],
  ] as const)("is found for %j", (changes, text) => {
    const found = obstacle(
      controller({ undrivable: text && "the server's", ...changes }),
    );
    if (text === null) expect(found).toBeNull();
    else expect(found).toContain(text);
  });

  it("is advised about in the person's language", () => {
    speak("zh");
    const stopped = controller({
      name: "arm",
      state: "stopped",
      undrivable: "stopped",
    });
    expect(advice(stopped)).toContain("arm 未运行");
    speak("en");
    expect(advice(controller())).toBeNull();
  });
});
