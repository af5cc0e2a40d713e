/** Mesh files, each read once. */
import { type BufferGeometry, LoadingManager, Mesh, type Object3D } from "three";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { serverUrl } from "../address";
import { meshKind } from "./mesh-kind";
import type { Coloured, Materials } from "./materials";

/** Sharper edges stay edges, the rest is round [rad]. */
const CREASE = Math.PI / 6;

async function fetched(url: string): Promise<Response> {
  const response = await fetch(url);
  if (!response.ok)
    throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return response;
}

/** Return a shape with normals from a file of bare triangles. */
function rounded(geometry: BufferGeometry): BufferGeometry {
  geometry.deleteAttribute("color");
  return toCreasedNormals(geometry, CREASE);
}

export class Meshes {
  private readonly stls = new Map<string, Promise<BufferGeometry>>();
  private readonly manager = new LoadingManager();

  constructor(private readonly materials: Materials) {
    // the textures of a mesh need the token too
    this.manager.setURLModifier((url) =>
      /^(data|blob):/.test(url) ? url : serverUrl(url),
    );
  }

  /** Return the mesh at `path` on the server; one without colours is of `material`. */
  async load(path: string, material: Coloured): Promise<Object3D> {
    const kind = meshKind(path);
    if (kind === undefined) {
      throw new Error(`${path} is no mesh that is read here; STL, DAE or OBJ would be`);
    }
    const url = serverUrl(path);
    if (kind === "stl") {
      return new Mesh(await this.stl(url), this.materials.ofUrdf(material));
    }
    const text = await (await fetched(url)).text();
    return kind === "dae"
      ? this.collada(text, url.slice(0, url.lastIndexOf("/") + 1))
      : this.obj(text, material);
  }

  private stl(url: string): Promise<BufferGeometry> {
    const known = this.stls.get(url);
    if (known) return known;
    const made = fetched(url)
      .then((response) => response.arrayBuffer())
      .then((data) => rounded(new STLLoader().parse(data)));
    this.stls.set(url, made);
    return made;
  }

  private async collada(text: string, folder: string): Promise<Object3D> {
    const { ColladaLoader } =
      await import("three/examples/jsm/loaders/ColladaLoader.js");
    const parsed = new ColladaLoader(this.manager).parse(text, folder);
    if (!parsed) throw new Error(`${folder}: no COLLADA file`);
    // ignore the lights and cameras in the files
    const strangers: Object3D[] = [];
    parsed.scene.traverse((object) => {
      if (object instanceof Mesh) {
        const mesh = object as Mesh<BufferGeometry, Coloured | Coloured[]>;
        mesh.material = Array.isArray(mesh.material)
          ? mesh.material.map((one) => this.materials.ofModel(one))
          : this.materials.ofModel(mesh.material);
      } else if ("isLight" in object || "isCamera" in object) strangers.push(object);
    });
    for (const stranger of strangers) stranger.removeFromParent();
    return parsed.scene;
  }

  private async obj(text: string, material: Coloured): Promise<Object3D> {
    const { OBJLoader } = await import("three/examples/jsm/loaders/OBJLoader.js");
    const parsed = new OBJLoader(this.manager).parse(text);
    parsed.traverse((object) => {
      if (object instanceof Mesh) object.material = this.materials.ofUrdf(material);
    });
    return parsed;
  }
}
