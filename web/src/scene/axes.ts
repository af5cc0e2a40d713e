/** Frames of links, drawn through everything: red is x, green y, blue z. */
import {
  BufferAttribute,
  type BufferGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  Group,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  type PerspectiveCamera,
  Vector3,
} from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";

/** Length of an axis, as a part of its distance from the camera. */
const SIZE = 0.085;
const LONGEST = 0.22;

function arrow(axis: 0 | 1 | 2): BufferGeometry {
  const shaft = new CylinderGeometry(0.018, 0.018, 0.8, 12).translate(0, 0.4, 0);
  const head = new ConeGeometry(0.055, 0.2, 16).translate(0, 0.9, 0);
  const whole = mergeGeometries([shaft, head]);
  if (axis === 0) whole.rotateZ(-Math.PI / 2);
  if (axis === 2) whole.rotateX(Math.PI / 2);
  return whole;
}

export class Axes {
  readonly root = new Group();
  private readonly geometry: BufferGeometry;
  private readonly material = new MeshBasicMaterial({
    vertexColors: true,
    depthTest: false,
    depthWrite: false,
    transparent: true,
    toneMapped: false,
  });
  private readonly drawn = new Map<string, { frame: Mesh; link: Object3D }>();
  private readonly eye = new Vector3();

  constructor() {
    this.geometry = mergeGeometries([arrow(2), arrow(1), arrow(0)]);
    this.paint(["#d6333a", "#2c9c4b", "#2867d8"]);
  }

  /** @param colours of x, y and z */
  paint(colours: readonly [string, string, string]): void {
    const count = this.geometry.getAttribute("position").count;
    const values = new Float32Array(count * 3);
    const colour = new Color();
    for (let i = 0; i < count; i++) {
      const axis = 2 - Math.floor((3 * i) / count);
      colour.set(colours[axis] ?? "").toArray(values, 3 * i);
    }
    this.geometry.setAttribute("color", new BufferAttribute(values, 3));
  }

  /** Draw these frames and no others. */
  show(links: ReadonlyMap<string, Object3D>): void {
    for (const [name, { frame }] of this.drawn) {
      if (links.has(name)) continue;
      frame.removeFromParent();
      this.drawn.delete(name);
    }
    for (const [name, link] of links) {
      if (this.drawn.has(name)) continue;
      const frame = new Mesh(this.geometry, this.material);
      frame.renderOrder = 10;
      this.root.add(frame);
      this.drawn.set(name, { frame, link });
    }
  }

  /** Put the frames where their links are, as large as they look best. */
  update(camera: PerspectiveCamera): void {
    for (const { frame, link } of this.drawn.values()) {
      link.updateWorldMatrix(true, false);
      link.matrixWorld.decompose(frame.position, frame.quaternion, frame.scale);
      const distance = this.eye.copy(frame.position).distanceTo(camera.position);
      frame.scale.setScalar(Math.min(LONGEST, SIZE * distance));
    }
  }

  /** The names of the frames and where to write them. */
  get labels(): { text: string; at: Vector3 }[] {
    return [...this.drawn].map(([text, { frame }]) => ({ text, at: frame.position }));
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
  }
}
