import { Mesh, Vector3 } from "three";
import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import type { RobotInfo } from "../src/protocol";
import { Ghost } from "../src/scene/ghost";
import { Materials } from "../src/scene/materials";
import { Meshes } from "../src/scene/meshes";
import { Robot, type SolidMesh } from "../src/scene/robot";
import { view, joint } from "./fixtures";

const URDF = `<robot name="r">
  <link name="world"/>
  <joint name="fixed" type="fixed"><parent link="world"/><child link="post"/></joint>
  <link name="post">
    <visual><geometry><mesh filename="/meshes/post.stl"/></geometry>
      <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material></visual>
    <collision><geometry><box size="0.1 0.1 0.2"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="post"/><child link="arm"/><origin xyz="0 0 1"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <link name="arm">
    <visual><origin xyz="1 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></visual>
    <collision><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <joint name="slave" type="revolute">
    <parent link="arm"/><child link="hand"/><origin xyz="2 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
    <mimic joint="hinge" multiplier="-1"/>
  </joint>
  <link name="hand"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
</robot>`;

/** One triangle, as a binary STL. */
function stl(): ArrayBuffer {
  const data = new DataView(new ArrayBuffer(84 + 50));
  data.setUint32(80, 1, true);
  [0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0].forEach((value, i) => {
    data.setFloat32(84 + 4 * i, value, true);
  });
  return data.buffer;
}

const INFO: RobotInfo = {
  ...view().robot,
  joints: [joint("hinge"), joint("slave", { mimics: "hinge" })],
};

const asked: string[] = [];

beforeEach(() => {
  asked.length = 0;
  window.history.replaceState(null, "", "/?token=secret");
  vi.stubGlobal("fetch", (url: string) => {
    asked.push(url);
    if (url.includes("post.stl")) return Promise.resolve(new Response(stl()));
    return Promise.resolve(new Response("", { status: 404 }));
  });
});

afterEach(() => {
  vi.unstubAllGlobals();
  window.history.replaceState(null, "", "/");
});

function load(): Promise<Robot> {
  const materials = new Materials("low");
  return Robot.load(INFO, URDF, new Meshes(materials), materials);
}

function placeOf(robot: Robot, link: string): Vector3 {
  robot.root.updateMatrixWorld(true);
  return robot.root.links[link]?.getWorldPosition(new Vector3()) ?? new Vector3(NaN);
}

/** In sRGB, as hexadecimal digits. */
function colourOf(mesh: SolidMesh | undefined): string | undefined {
  return [mesh?.material].flat()[0]?.color.getHexString();
}

describe("the robot", () => {
  test("fetches its meshes with the token of the page", async () => {
    await load();
    expect(asked).toHaveLength(1);
    expect(new URL(asked[0] ?? "").searchParams.get("token")).toBe("secret");
  });

  test("has its shapes by link, and the colours of the URDF", async () => {
    const robot = await load();
    expect([...robot.visuals.keys()]).toEqual(["post", "arm", "hand"]);
    expect(colourOf(robot.visuals.get("post")?.[0])).toBe("808080");
    expect(robot.failures).toEqual([]);
  });

  test("stands as the values say, beyond a limit too", async () => {
    const robot = await load();
    robot.pose([Math.PI / 2, 0]);
    expect(placeOf(robot, "hand").distanceTo(new Vector3(0, 2, 1))).toBeLessThan(1e-9);
  });

  test("a joint that mimics another has the value that it really has", async () => {
    const robot = await load();
    robot.pose([0.3, 0.1]);
    expect(robot.root.joints.slave?.angle).toBe(0.1);
    robot.pose([0.5, 0.1]);
    expect(robot.root.joints.slave?.angle).toBe(0.1);
  });

  test("shows collision shapes only once they are asked for", async () => {
    const robot = await load();
    const look = vi.fn();
    await robot.showCollision(false, look);
    expect(look).not.toHaveBeenCalled();
    await robot.showCollision(true, look);
    expect(look).toHaveBeenCalledTimes(2);
    await robot.showCollision(true, look);
    expect(look).toHaveBeenCalledTimes(2);
    // they move with their links, and are no part of what the pointer finds
    expect(robot.visuals.get("arm")).toHaveLength(1);
    robot.pose([Math.PI / 2, 0]);
    const shape = look.mock.calls[1]?.[0] as Mesh;
    expect(
      placeOf(robot, "arm").distanceTo(shape.getWorldPosition(new Vector3())),
    ).toBe(0);
  });

  test("says which mesh is missing, and stands without it", async () => {
    vi.stubGlobal("fetch", () =>
      Promise.resolve(new Response("", { status: 404, statusText: "Not Found" })),
    );
    const robot = await load();
    expect(robot.failures).toHaveLength(1);
    expect(robot.failures[0]).toContain("post.stl");
    expect([...robot.visuals.keys()]).toEqual(["arm", "hand"]);
  });
});

describe("the ghost", () => {
  test("doubles the links that are elsewhere, followers with them", async () => {
    const robot = await load();
    const ghost = new Ghost(robot);
    robot.pose([0, 0]);
    expect(ghost.show(new Map([["hinge", 0.4]]))).toBe(true);
    const shown = (link: string) =>
      robot.twin.links[link]?.children.some((visual) =>
        visual.children.some((mesh) => mesh instanceof Mesh && mesh.visible),
      );
    expect(robot.twin.visible).toBe(true);
    expect(shown("post")).toBe(false);
    expect(shown("arm")).toBe(true);
    expect(robot.twin.joints.slave?.angle).toBe(-0.4);
    // and the robot is still where it was
    expect(robot.root.joints.slave?.angle).toBe(0);
  });

  test("goes when the goal is reached", async () => {
    const robot = await load();
    const ghost = new Ghost(robot);
    ghost.show(new Map([["hinge", 0.4]]));
    expect(ghost.show(undefined)).toBe(true);
    expect(robot.twin.visible).toBe(false);
    expect(ghost.show(undefined)).toBe(false);
  });
});
