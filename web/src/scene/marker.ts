/** A ring on the ground around the base of the selected robot. */
import {
  Box3,
  DoubleSide,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  RingGeometry,
  Vector3,
} from "three";
import type { URDFJoint } from "urdf-loader";
import { meshesOf } from "./robot";

/** Between what stands there and the ring [m]. */
const GAP = 0.05;
const WIDTH = 0.012;
/** Radius around a base without a shape [m]. */
const BARE = 0.1;
/** Above the ground, so that both do not flicker [m]. */
const LIFT = 0.002;

/** Return the link and all links that are fixed to it. */
function fixedTo(link: Object3D): Object3D[] {
  const fixed = link.children.filter(
    (child) => "isURDFJoint" in child && (child as URDFJoint).jointType === "fixed",
  );
  return [link, ...fixed.flatMap((joint) => joint.children.flatMap(fixedTo))];
}

/** Return the radius around `link` of what is fixed to it [m]. */
function radiusOf(link: Object3D): number {
  const centre = link.getWorldPosition(new Vector3());
  const box = new Box3();
  for (const mesh of fixedTo(link).flatMap(meshesOf)) box.expandByObject(mesh);
  if (box.isEmpty()) return BARE;
  return Math.max(
    box.max.x - centre.x,
    centre.x - box.min.x,
    box.max.y - centre.y,
    centre.y - box.min.y,
  );
}

export class Marker {
  private readonly material = new MeshBasicMaterial({
    transparent: true,
    opacity: 0.7,
    depthWrite: false,
    side: DoubleSide,
    toneMapped: false,
  });
  readonly root = new Mesh(new RingGeometry(), this.material);
  private base: Object3D | undefined;

  /** @param ground its height [m]; without one the ring is as high as the base */
  constructor(private readonly ground: number | null) {
    this.root.visible = false;
  }

  paint(colour: string): void {
    this.material.color.set(colour);
  }

  /** Mark the robot with this base, or none. */
  mark(base: Object3D | undefined): void {
    this.base = base;
    this.root.visible = base !== undefined;
    if (!base) return;
    base.updateWorldMatrix(true, true);
    const inner = radiusOf(base) + GAP;
    this.root.geometry.dispose();
    this.root.geometry = new RingGeometry(inner, inner + WIDTH, 96);
    this.follow();
  }

  /** Put the ring where the base is. */
  follow(): void {
    if (!this.base) return;
    this.base.getWorldPosition(this.root.position);
    this.root.position.z = (this.ground ?? this.root.position.z) + LIFT;
  }

  dispose(): void {
    this.root.geometry.dispose();
    this.material.dispose();
  }
}
