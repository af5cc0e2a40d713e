/** Centres of mass, and boxes that have the mass and the inertia of each link. */
import {
  EdgesGeometry,
  BoxGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  SphereGeometry,
} from "three";
import { fromRpy } from "../kinematics";
import type { Inertial, UrdfModel } from "../urdf";
import { quaternionOf } from "./orientation";
import { principalAxes } from "./principal-axes";

const DOT = 0.009;
/** Below this the box of a link could not be seen [m]. */
const LEAST = 1e-3;

/** Return the edges of the box of uniform density with these principal moments [kg·m²]. */
export function boxOf(
  mass: number,
  [a, b, c]: readonly [number, number, number],
): [number, number, number] {
  const edge = (sum: number) => Math.sqrt(Math.max(0, (6 * sum) / mass));
  return [edge(b + c - a), edge(a + c - b), edge(a + b - c)];
}

export class Inertias {
  private readonly edges = new LineBasicMaterial({
    depthTest: false,
    transparent: true,
    opacity: 0.75,
    toneMapped: false,
  });
  private readonly faces = new MeshBasicMaterial({
    depthTest: false,
    depthWrite: false,
    transparent: true,
    opacity: 0.08,
    toneMapped: false,
  });
  private readonly dot = new MeshBasicMaterial({
    depthTest: false,
    transparent: true,
    toneMapped: false,
  });
  private groups: Group[] = [];

  paint(colour: string, dot: string): void {
    this.edges.color.set(colour);
    this.faces.color.set(colour);
    this.dot.color.set(dot);
  }

  /** Show the links of a model, or nothing. */
  show(model: UrdfModel | null, linkOf: (name: string) => Object3D | undefined): void {
    this.clear();
    for (const { name, inertial } of model?.links.values() ?? []) {
      const link = linkOf(name);
      if (!link || !inertial || inertial.mass <= 0) continue;
      const group = this.drawn(inertial);
      link.add(group);
      this.groups.push(group);
    }
  }

  dispose(): void {
    this.clear();
    for (const material of [this.edges, this.faces, this.dot]) material.dispose();
  }

  private clear(): void {
    for (const group of this.groups) {
      group.removeFromParent();
      group.traverse((one) => {
        if ("geometry" in one) (one as Mesh).geometry.dispose();
      });
    }
    this.groups = [];
  }

  private drawn({ mass, origin, inertia }: Inertial): Group {
    const group = new Group();
    const { moments, axes } = principalAxes(inertia);
    const size = boxOf(mass, moments).map((edge) => Math.max(edge, LEAST));
    const [x = LEAST, y = LEAST, z = LEAST] = size;
    const box = new BoxGeometry(x, y, z);
    const faces = new Mesh(box, this.faces);
    const edges = new LineSegments(new EdgesGeometry(box), this.edges);
    const turned = new Group();
    turned.quaternion.copy(quaternionOf(axes));
    turned.add(faces, edges);
    const dot = new Mesh(new SphereGeometry(DOT, 20, 14), this.dot);
    group.position.set(...origin.xyz);
    group.quaternion.copy(quaternionOf(fromRpy(origin.rpy)));
    group.add(turned, dot);
    group.traverse((one) => {
      one.renderOrder = one === dot ? 8 : 7;
      one.raycast = () => undefined;
    });
    return group;
  }
}
