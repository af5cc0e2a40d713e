/** The objects of the scene, as they are added and removed. */
import {
  BoxGeometry,
  type BufferGeometry,
  CylinderGeometry,
  Group,
  Mesh,
  MeshPhongMaterial,
  SphereGeometry,
} from "three";
import { fromRpy } from "../kinematics";
import type { ShapeInfo, ViewObject, ViewScene } from "../protocol";
import type { Pose } from "./interpolation";
import { MODEL_LAYER } from "./layers";
import type { Materials } from "./materials";
import type { Meshes } from "./meshes";
import { quaternionOf } from "./orientation";
import { meshesOf, type SolidMesh } from "./robot";

/** Return the geometry of a shape without parts. */
export function primitive(shape: ShapeInfo): BufferGeometry {
  const radius = shape.radius ?? 0;
  if (shape.kind === "sphere") return new SphereGeometry(radius, 48, 24);
  if (shape.kind === "cylinder") {
    // three.js cylinders are along y, ours along z
    return new CylinderGeometry(radius, radius, shape.length ?? 0, 64).rotateX(
      Math.PI / 2,
    );
  }
  const [x, y, z] = shape.size ?? [1, 1, 1];
  return new BoxGeometry(x, y, z);
}

/** An object and its description; `failure` is the reason if it has no shape. */
interface Shown {
  readonly key: string;
  readonly holder: Group;
  failure?: string;
  readonly made: Promise<void>;
}

export class Objects {
  readonly root = new Group();
  /** In the order of the poses of a frame of this scene. */
  private shown: Shown[] = [];
  private number = -1;

  constructor(
    private readonly meshes: Meshes,
    private readonly materials: Materials,
  ) {}

  /** Parts of these objects that could not be loaded. */
  get failures(): readonly string[] {
    return this.shown.flatMap(({ failure }) => failure ?? []);
  }

  /** Show exactly these objects; existing ones are kept. */
  async show(scene: ViewScene): Promise<void> {
    const before = new Map(this.shown.map((one) => [one.key, one]));
    this.shown = scene.objects.map((info) => {
      const key = JSON.stringify(info);
      const known = before.get(key);
      before.delete(key);
      return known ?? this.add(info, key);
    });
    this.number = scene.number;
    for (const { holder } of before.values()) {
      holder.removeFromParent();
      holder.traverse((one) => {
        if (one instanceof Mesh) (one.geometry as BufferGeometry).dispose();
      });
    }
    await Promise.all(this.shown.map((one) => one.made));
  }

  /** Return the meshes of an object. */
  meshesOf(name: string): SolidMesh[] {
    const holder = this.holder(name);
    return holder ? meshesOf(holder) : [];
  }

  /** Return what an object is drawn in. */
  holder(name: string): Group | undefined {
    return this.shown.find(({ holder }) => holder.name === name)?.holder;
  }

  /** Set their poses from `start` on: x y z w x y z of each. */
  pose({ values, scene }: Pose, start: number): void {
    if (scene !== this.number) return;
    const at = (index: number) => values[index] ?? 0;
    this.shown.forEach(({ holder }, index) => {
      const i = start + 7 * index;
      holder.position.set(at(i), at(i + 1), at(i + 2));
      holder.quaternion.set(at(i + 4), at(i + 5), at(i + 6), at(i + 3)).normalize();
      holder.visible = true;
    });
  }

  private add(info: ViewObject, key: string): Shown {
    const holder = new Group();
    holder.name = info.name;
    // until a frame has its pose
    holder.visible = false;
    this.root.add(holder);
    const shown: Shown = { key, holder, made: this.fill(holder, info).catch(report) };
    function report(reason: unknown): void {
      shown.failure = String(reason);
    }
    return shown;
  }

  /** Draw an object into its holder; those of the shapes that can be drawn. */
  private async fill(holder: Group, info: ViewObject): Promise<void> {
    const { shape } = info;
    if (shape.kind !== "compound") {
      await this.draw(holder, shape, info);
      return;
    }
    const drawn = (shape.parts ?? []).map(async (part) => {
      const group = new Group();
      group.position.set(...part.xyz);
      group.quaternion.copy(quaternionOf(fromRpy(part.rpy)));
      holder.add(group);
      await this.draw(group, part.shape, info);
    });
    await Promise.all(drawn);
  }

  private async draw(
    holder: Group,
    shape: ShapeInfo,
    { name, rgba }: ViewObject,
  ): Promise<void> {
    if (shape.kind === "mesh") {
      if (shape.size) holder.scale.set(...shape.size);
      const look = new MeshPhongMaterial({ opacity: rgba[3] });
      look.color.setRGB(rgba[0], rgba[1], rgba[2]);
      holder.add(await this.meshes.load(shape.url ?? "", look));
    } else {
      holder.add(new Mesh(primitive(shape), this.materials.of(rgba)));
    }
    holder.traverse((one) => {
      one.layers.enable(MODEL_LAYER);
      one.userData.object = name;
      one.castShadow = one.receiveShadow = true;
    });
  }
}
