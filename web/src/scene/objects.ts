/** The objects of the scene. */
import {
  BoxGeometry,
  type BufferGeometry,
  CylinderGeometry,
  Group,
  Mesh,
  MeshPhongMaterial,
  SphereGeometry,
} from "three";
import type { ObjectInfo } from "../protocol";
import { MODEL_LAYER } from "./layers";
import type { Materials } from "./materials";
import type { Meshes } from "./meshes";

function primitive(shape: ObjectInfo["shape"]): BufferGeometry {
  const radius = shape.radius ?? 0;
  if (shape.kind === "sphere") return new SphereGeometry(radius, 48, 24);
  if (shape.kind === "cylinder") {
    // three's stand along y, ours along z
    return new CylinderGeometry(radius, radius, shape.length ?? 0, 64).rotateX(
      Math.PI / 2,
    );
  }
  const [x, y, z] = shape.size ?? [1, 1, 1];
  return new BoxGeometry(x, y, z);
}

export class Objects {
  readonly root = new Group();
  private constructor(readonly failures: readonly string[]) {}

  static async load(
    infos: readonly ObjectInfo[],
    meshes: Meshes,
    materials: Materials,
  ): Promise<Objects> {
    const failures: string[] = [];
    const objects = new Objects(failures);
    const made = infos.map(async ({ name, shape, rgba }) => {
      const holder = new Group();
      holder.name = name;
      objects.root.add(holder);
      if (shape.kind === "mesh") {
        if (shape.size) holder.scale.set(...shape.size);
        const look = new MeshPhongMaterial({ opacity: rgba[3] });
        look.color.setRGB(rgba[0], rgba[1], rgba[2]);
        holder.add(await meshes.load(shape.url ?? "", look));
      } else {
        holder.add(new Mesh(primitive(shape), materials.of(rgba)));
      }
      holder.traverse((one) => {
        one.layers.enable(MODEL_LAYER);
        one.userData.object = name;
        one.castShadow = one.receiveShadow = true;
      });
    });
    for (const result of await Promise.allSettled(made)) {
      if (result.status === "rejected") failures.push(String(result.reason));
    }
    return objects;
  }

  /** Put them where `values`, from `start` on, says: x y z w x y z of each. */
  pose(values: ArrayLike<number>, start: number): void {
    const at = (index: number) => values[index] ?? 0;
    this.root.children.forEach((object, index) => {
      const i = start + 7 * index;
      object.position.set(at(i), at(i + 1), at(i + 2));
      object.quaternion.set(at(i + 4), at(i + 5), at(i + 6), at(i + 3)).normalize();
    });
  }
}
