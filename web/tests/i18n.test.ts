import { afterEach, describe, expect, it } from "vitest";
import { language, speak, t } from "../src/i18n";
import { en } from "../src/i18n/en";
import { zh } from "../src/i18n/zh";

const placeholders = (text: string) =>
  [...text.matchAll(/\{(\w+)\}/g)].map(String).sort();

describe("the texts", () => {
  afterEach(() => {
    speak("en");
  });

  it("are the same in both languages, with the same placeholders", () => {
    expect(Object.keys(zh).sort()).toEqual(Object.keys(en).sort());
    for (const key of Object.keys(en) as (keyof typeof en)[]) {
      expect(zh[key], key).not.toBe("");
      expect(placeholders(zh[key]), key).toEqual(placeholders(en[key]));
    }
  });

  it("are spoken as the person chose, and the document says so", () => {
    speak("zh");
    expect(t("tab.tree")).toBe(zh["tab.tree"]);
    expect(document.documentElement.lang).toBe("zh-CN");
    expect(localStorage.getItem("tool0.language")).toBe("zh");
    speak("en");
    expect(document.documentElement.lang).toBe("en");
  });

  it("take values, and keep a placeholder that got none", () => {
    language.value = "en";
    expect(t("poses.saved", { name: "home" })).toBe("Saved as home");
    expect(t("poses.saved")).toContain("{name}");
  });

  it("have the word for one, and for several", () => {
    const say = (episodes: number) => t("episodes.count", { episodes, succeeded: 1 });
    expect(say(1)).toBe("1 episode, 1 succeeded");
    expect(say(2)).toBe("2 episodes, 1 succeeded");
    expect(say(0)).toBe("0 episodes, 1 succeeded");
  });
});
