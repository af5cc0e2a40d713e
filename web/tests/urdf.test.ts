import { describe, expect, it } from "vitest";
import { fromRpy, linkPose, toRpy } from "../src/kinematics";
import { parseUrdf } from "../src/urdf";
import type { Vector } from "../src/urdf";
import { UR5 } from "./ur5";

const zeros = () => 0;

function expectNear(actual: Vector, wanted: Vector, digits = 6): void {
  actual.forEach((value, index) => {
    expect(value).toBeCloseTo(wanted[index] ?? NaN, digits);
  });
}

describe("the reader of URDF", () => {
  const ur5 = parseUrdf(UR5);

  it("finds root, links, masses and limits", () => {
    expect(ur5.root).toBe("base_link");
    expect(ur5.links.size).toBe(10);
    expect(ur5.links.get("shoulder")?.inertial?.mass).toBe(3.7);
    expect(ur5.links.get("tool0")?.inertial).toBeNull();
    expect(ur5.parentJoint.get("forearm")).toMatchObject({
      name: "elbow_joint",
      type: "revolute",
      lower: -3.14,
      effort: 150,
      axis: [0, 0, 1],
    });
    expect(ur5.childJoints.get("base_link")?.map((joint) => joint.name)).toEqual([
      "turned",
    ]);
  });

  it("knows what URDF leaves out", () => {
    const { parentJoint } = parseUrdf(`<robot name="r"><link name="a"/><link name="b"/>
      <joint name="j" type="continuous"><parent link="a"/><child link="b"/>
      <limit effort="1" velocity="2" lower="0" upper="0"/>
      <mimic joint="k" multiplier="-2"/></joint></robot>`);
    expect(parentJoint.get("b")).toMatchObject({
      axis: [1, 0, 0],
      lower: null,
      upper: null,
      origin: { xyz: [0, 0, 0], rpy: [0, 0, 0] },
      mimic: { joint: "k", multiplier: -2, offset: 0 },
    });
  });

  it("says what is wrong", () => {
    expect(() => parseUrdf("<html/>")).toThrow(/<robot>/);
    expect(() =>
      parseUrdf('<robot name="r"><link name="a"/><link name="b"/></robot>'),
    ).toThrow("this has 2: a, b");
  });
});

describe("forward kinematics", () => {
  const ur5 = parseUrdf(UR5);

  it("puts the tool of a UR5 at zero where its DH parameters put it", () => {
    const { p } = linkPose(ur5, "tool0", zeros);
    expectNear(p, [0.81725, 0.19145, -0.005491]);
  });

  it("puts it straight up for shoulder and wrist 1 at -90°", () => {
    const up: Record<string, number> = {
      shoulder_lift_joint: -Math.PI / 2,
      wrist_1_joint: -Math.PI / 2,
    };
    const { p } = linkPose(ur5, "tool0", (joint) => up[joint] ?? 0);
    expectNear(p, [0, 0.19145, 0.089159 + 0.425 + 0.39225 + 0.09465]);
  });

  it("turns with the first joint", () => {
    const quarter = (joint: string) =>
      joint === "shoulder_pan_joint" ? Math.PI / 2 : 0;
    expectNear(linkPose(ur5, "tool0", quarter).p, [-0.19145, 0.81725, -0.005491]);
  });

  it("moves prismatic joints along their axes, and followers with their leaders", () => {
    const lift =
      parseUrdf(`<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="up" type="prismatic"><parent link="a"/><child link="b"/>
      <origin xyz="0 0 1"/><axis xyz="0 0 2"/></joint>
      <joint name="along" type="prismatic"><parent link="b"/><child link="c"/>
      <axis xyz="1 0 0"/><mimic joint="up" multiplier="-2" offset="0.5"/></joint></robot>`);
    const positions: Record<string, number> = { up: 0.25 };
    const { p } = linkPose(lift, "c", (joint) => positions[joint]);
    expectNear(p, [0, 0, 1.25]);
    positions["up"] = 0.1;
    expectNear(linkPose(lift, "c", (joint) => positions[joint]).p, [0.3, 0, 1.1]);
  });

  it.each([
    [0.1, -0.2, 0.3],
    [-3, 1.5, 2],
    [0, Math.PI / 2, 1],
    [0, -Math.PI / 2, -2],
  ] as Vector[])("reads back roll %f, pitch %f, yaw %f", (...rpy) => {
    expectNear(toRpy(fromRpy(rpy)), rpy);
  });
});
