import { describe, expect, it } from "vitest";
import { moveOf, visibleRows } from "../src/panels/tree-keys";
import { parseUrdf } from "../src/urdf";

const joint = (parent: string, child: string) =>
  `<joint name="${parent}-${child}" type="fixed"><parent link="${parent}"/><child link="${child}"/></joint>`;
const links = ["root", "left", "finger", "right"].map(
  (name) => `<link name="${name}"/>`,
);
const tree = parseUrdf(
  `<robot name="r">${links.join("")}${joint("root", "left")}${joint("left", "finger")}${joint("root", "right")}</robot>`,
);
const open = new Set<string>();
const rows = visibleRows(tree, open);

describe("the tree", () => {
  it("goes down each branch before the next", () => {
    expect(rows.map((row) => [row.link, row.level, row.place, row.siblings])).toEqual([
      ["root", 1, 1, 1],
      ["left", 2, 1, 2],
      ["finger", 3, 1, 1],
      ["right", 2, 2, 2],
    ]);
  });

  it("hides what is folded", () => {
    const seen = visibleRows(tree, new Set(["left"])).map((row) => row.link);
    expect(seen).toEqual(["root", "left", "right"]);
  });

  it.each([
    ["ArrowDown", "left", { focus: "finger" }],
    ["ArrowUp", "left", { focus: "root" }],
    ["ArrowUp", "root", undefined],
    ["End", "root", { focus: "right" }],
    ["ArrowRight", "left", { focus: "finger" }],
    ["ArrowRight", "finger", undefined],
    ["ArrowLeft", "left", { fold: "left" }],
    ["ArrowLeft", "finger", { focus: "left" }],
    ["x", "left", undefined],
  ])("answers %s at %s", (key, link, move) => {
    expect(moveOf(key, link, rows, open)).toEqual(move);
  });

  it("unfolds before it goes in", () => {
    const folded = new Set(["left"]);
    const seen = visibleRows(tree, folded);
    expect(moveOf("ArrowRight", "left", seen, folded)).toEqual({ unfold: "left" });
  });
});
