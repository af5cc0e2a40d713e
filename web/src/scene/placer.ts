/** The object that the pointer places, before it is added. */
import { Mesh, MeshLambertMaterial, Vector3 } from "three";
import type { NewObject, SimpleShape } from "../placing";
import { primitive } from "./objects";
import type { Hit } from "./picker";

/** Between the object and the surface below it, so that both do not overlap [m]. */
const GAP = 0.001;

/** Return how far a shape reaches from its origin along a unit vector [m]. */
export function reachOf(shape: SimpleShape, { x, y, z }: Vector3): number {
  switch (shape.kind) {
    case "sphere":
      return shape.radius;
    case "cylinder":
      return Math.abs(z) * (shape.length / 2) + Math.hypot(x, y) * shape.radius;
    case "box": {
      const [a, b, c] = shape.size;
      return (Math.abs(x) * a + Math.abs(y) * b + Math.abs(z) * c) / 2;
    }
  }
}

export class Placer {
  private readonly material = new MeshLambertMaterial({
    transparent: true,
    opacity: 0.55,
    depthWrite: false,
  });
  readonly root = new Mesh(undefined, this.material);
  private object: NewObject | null = null;

  constructor() {
    this.root.visible = false;
    this.root.renderOrder = 2;
  }

  paint(colour: string): void {
    this.material.color.set(colour);
  }

  /** Place this object, or none. */
  offer(object: NewObject | null): void {
    this.object = object;
    this.root.visible = false;
    if (!object) return;
    this.root.geometry.dispose();
    this.root.geometry = primitive(object.shape);
  }

  /** Show the object on a surface; the result is its origin [m]. */
  put(on: Pick<Hit, "point" | "normal"> | undefined): Vector3 | undefined {
    this.root.visible = on !== undefined && this.object !== null;
    if (!on || !this.object) return undefined;
    const reach = reachOf(this.object.shape, on.normal) + GAP;
    return this.root.position.copy(on.point).addScaledVector(on.normal, reach).clone();
  }

  dispose(): void {
    this.root.geometry.dispose();
    this.material.dispose();
  }
}
