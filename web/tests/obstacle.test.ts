import { describe, expect, it } from "vitest";
import { speak } from "../src/i18n";
import { advice, obstacle } from "../src/panels/obstacle";
import { controller } from "./fixtures";

describe("what keeps sliders from driving", () => {
  it.each([
    [{}, null],
    [{ type: "joint_state_controller/JointStateController" }, "where the joints are"],
    [{ type: "effort_controllers/JointGroupEffortController" }, "JointGroupEffortCont"],
    [{ state: "unloaded" }, "not loaded"],
    [{ state: "stopped" }, "not running"],
    [{ undrivable: "no limits" }, "no limits"],
  ] as const)("is told for %j", (changes, text) => {
    const told = obstacle(
      controller({ undrivable: text && "the server's", ...changes }),
    );
    if (text === null) expect(told).toBeNull();
    else expect(told).toContain(text);
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
    expect(advice(controller())).toContain("until you drive it");
  });
});
