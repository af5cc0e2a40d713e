import { MeshPhongMaterial, Vector3 } from "three";
import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { Materials } from "../src/scene/materials";
import { Meshes } from "../src/scene/meshes";
import { meshesOf, type SolidMesh } from "../src/scene/robot";

/** A triangle of one green, beside a light that the modeller left. */
const DAE = `<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>
  <library_lights><light id="sun"><technique_common><point><color>1 1 1</color></point>
    </technique_common></light></library_lights>
  <library_effects><effect id="e"><profile_COMMON><technique sid="common"><lambert>
    <diffuse><color>0 1 0 1</color></diffuse></lambert></technique></profile_COMMON></effect>
  </library_effects>
  <library_materials><material id="m"><instance_effect url="#e"/></material>
  </library_materials>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array>
      <technique_common><accessor source="#pa" count="3" stride="3"/></technique_common>
    </source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
      <p>0 1 2</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="scene">
    <node><instance_light url="#sun"/></node>
    <node><instance_geometry url="#g"><bind_material><technique_common>
      <instance_material symbol="s" target="#m"/></technique_common></bind_material>
    </instance_geometry></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>`;

const OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/** Two triangles of a roof: at 20° to each other they are round, at 90° there is an edge. */
function roof(angle: number): ArrayBuffer {
  const data = new DataView(new ArrayBuffer(84 + 2 * 50));
  const [y, z] = [Math.cos(angle), Math.sin(angle)];
  const triangles = [
    [0, 0, 0, 1, 0, 0, 0, -1, 0],
    [0, 0, 0, 0, y, z, 1, 0, 0],
  ];
  data.setUint32(80, triangles.length, true);
  triangles.forEach((corners, i) => {
    corners.forEach((value, j) => {
      data.setFloat32(84 + 50 * i + 12 + 4 * j, value, true);
    });
  });
  return data.buffer;
}

let files: Record<string, string | ArrayBuffer> = {};
const fetched = vi.fn((url: string) => {
  const file = files[new URL(url).pathname];
  return Promise.resolve(new Response(file ?? "", { status: file ? 200 : 404 }));
});

beforeEach(() => {
  files = { "/a.dae": DAE, "/a.obj": OBJ };
  fetched.mockClear();
  vi.stubGlobal("fetch", fetched);
});

afterEach(() => {
  vi.unstubAllGlobals();
});

/** In sRGB, as hexadecimal digits. */
function colourOf(mesh: SolidMesh | undefined): string | undefined {
  return [mesh?.material].flat()[0]?.color.getHexString();
}

const red = new MeshPhongMaterial();
red.color.setRGB(1, 0, 0);

function reader(): Meshes {
  return new Meshes(new Materials("low"));
}

describe("a mesh file", () => {
  test("of COLLADA keeps its own colours, and loses its lights", async () => {
    const found = await reader().load("/a.dae", red);
    const [mesh] = meshesOf(found);
    expect(colourOf(mesh)).toBe("00ff00");
    expect(mesh?.geometry.getAttribute("position").count).toBe(3);
    let lights = 0;
    found.traverse((object) => {
      if ("isLight" in object) lights += 1;
    });
    expect(lights).toBe(0);
  });

  test("of OBJ has the colour of the URDF", async () => {
    const [mesh] = meshesOf(await reader().load("/a.obj", red));
    expect(colourOf(mesh)).toBe("ff0000");
  });

  test.each([
    [20, "round", true],
    [90, "an edge", false],
  ])("of STL: where faces meet at %s° there is %s", async (degrees, _what, round) => {
    files["/roof.stl"] = roof((degrees * Math.PI) / 180);
    const [mesh] = meshesOf(await reader().load("/roof.stl", red));
    const normals = mesh?.geometry.getAttribute("normal");
    const first = new Vector3().fromBufferAttribute(normals as never, 0);
    const other = new Vector3().fromBufferAttribute(normals as never, 3);
    expect(first.length()).toBeCloseTo(1);
    expect(first.angleTo(other) < 1e-6).toBe(round);
  });

  test("is fetched once, however many links have it", async () => {
    files["/a.stl"] = roof(0);
    const meshes = reader();
    const found = await Promise.all([
      meshes.load("/a.stl", red),
      meshes.load("/a.stl", red),
    ]);
    expect(fetched).toHaveBeenCalledTimes(1);
    const [one, two] = found.flatMap(meshesOf);
    expect(one?.geometry).toBe(two?.geometry);
  });

  test.each([
    ["/none.stl", "404"],
    ["/arm.glb", "STL, DAE or OBJ"],
  ])("%s is refused with a reason", async (path, reason) => {
    await expect(reader().load(path, red)).rejects.toThrow(reason);
  });
});
