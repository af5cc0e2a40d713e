import { describe, expect, test } from "vitest";
import { goalOf } from "../src/scene/goal";
import { Materials, finishOf } from "../src/scene/materials";
import { meshKind } from "../src/scene/mesh-kind";
import { qualityFor } from "../src/scene/quality";
import { joint } from "./fixtures";

describe("the goal is shown", () => {
  const joints = [
    joint("elbow"),
    joint("finger"),
    joint("left_finger", { mimics: "finger" }),
  ];

  test("where it differs from where the robot is", () => {
    const goal = goalOf(joints, [0, 0.1, 0.1], { elbow: 0.5 });
    expect(goal).toEqual(
      new Map([
        ["elbow", 0.5],
        ["finger", 0.1],
      ]),
    );
  });

  test("not for the error of a controller at rest", () => {
    expect(goalOf(joints, [0, 0, 0], { elbow: 0.02 })).toBeUndefined();
    expect(goalOf(joints, [0, 0, 0], { elbow: -0.03 })).toBeDefined();
    const slide = [joint("slide", { type: "prismatic" })];
    expect(goalOf(slide, [0], { slide: 0.005 })).toBeDefined();
  });

  test("not where there is none", () => {
    expect(goalOf(joints, [1, 2, 3], {})).toBeUndefined();
  });

  test("a joint that mimics another is not asked", () => {
    expect(goalOf(joints, [0, 0, 5], { left_finger: 0 })).toBeUndefined();
  });
});

describe("meshes", () => {
  test.each([
    ["/meshes/a/b.stl", "stl"],
    ["/meshes/a/B.STL?token=x.dae", "stl"],
    ["arm.dae", "dae"],
    ["arm.v2.obj#part", "obj"],
  ])("%s is read as %s", (url, kind) => {
    expect(meshKind(url)).toBe(kind);
  });

  test.each(["arm.glb", "arm", "stl", "/a.stl/arm"])("%s cannot be read", (url) => {
    expect(meshKind(url)).toBeUndefined();
  });
});

describe("quality", () => {
  test.each([
    "ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero) (0x0000C0DE)), SwiftShader driver)",
    "llvmpipe (LLVM 15.0.6, 256 bits)",
    "Microsoft Basic Render Driver",
  ])("%s draws on the CPU: low", (renderer) => {
    expect(qualityFor(renderer)).toBe("low");
  });

  test.each([
    "ANGLE (NVIDIA, NVIDIA GeForce RTX 3060 Direct3D11 vs_5_0 ps_5_0, D3D11)",
    "Mesa Intel(R) UHD Graphics 620 (KBL GT2)",
    "Apple GPU",
  ])("%s is a GPU: high", (renderer) => {
    expect(qualityFor(renderer)).toBe("high");
  });
});

describe("materials", () => {
  test("light grey is metal; black and blue are plastic", () => {
    expect(finishOf(0.75, 0.76, 0.78).metalness).toBeGreaterThan(0.3);
    expect(finishOf(0.12, 0.12, 0.13).metalness).toBe(0);
    expect(finishOf(0.45, 0.62, 0.74).metalness).toBe(0);
  });

  test("one colour is one material, the URDF's numbers being sRGB", () => {
    const materials = new Materials("high");
    const grey = materials.of([0.5, 0.5, 0.5, 1]);
    expect(materials.of([0.5, 0.5, 0.5, 1])).toBe(grey);
    expect(grey.color.getHexString()).toBe("808080");
    expect(materials.of([0.5, 0.5, 0.5, 0.4]).transparent).toBe(true);
  });

  test("what glows can be put out", () => {
    const materials = new Materials("low");
    const plain = materials.of([1, 0, 0, 1]);
    const glowing = materials.glowingOf(plain, "#f2a33a");
    expect(glowing).not.toBe(plain);
    expect(materials.plainOf(glowing)).toBe(plain);
    expect(materials.plainOf(plain)).toBe(plain);
  });
});
