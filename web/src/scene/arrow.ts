/** An arrow for a force: its length shows the size, drawn through everything. */
import {
  ConeGeometry,
  CylinderGeometry,
  Group,
  Mesh,
  type Material,
  Quaternion,
  TorusGeometry,
  Vector3,
} from "three";

const SHAFT = 0.0045;
const HEAD = { radius: 0.013, length: 0.034 };
const UP = new Vector3(0, 1, 0);
const FORWARD = new Vector3(0, 0, 1);

/** Return the length of an arrow for a force [m]: 1 N is 3 cm, 100 N 30 cm. */
export function lengthOf(force: number): number {
  return Math.min(0.03 * Math.sqrt(force), 0.45);
}

export class Arrow {
  readonly root = new Group();
  /** Where to write beside it. */
  readonly tip = new Vector3();
  private readonly shaft: Mesh;
  private readonly head: Mesh;

  constructor(material: Material) {
    const shaft = new CylinderGeometry(SHAFT, SHAFT, 1, 12).translate(0, 0.5, 0);
    const head = new ConeGeometry(HEAD.radius, HEAD.length, 20);
    this.shaft = new Mesh(shaft, material);
    this.head = new Mesh(head.translate(0, HEAD.length / 2, 0), material);
    this.shaft.renderOrder = this.head.renderOrder = 11;
    this.root.add(this.shaft, this.head);
  }

  /** Point from `from` along `force` [N], as long as that is large. */
  aim(from: Vector3, force: Vector3): void {
    const size = force.length();
    const length = lengthOf(size);
    const shaft = Math.max(0.002, length - HEAD.length);
    const direction = force.clone().divideScalar(size);
    this.root.position.copy(from);
    this.root.quaternion.setFromUnitVectors(UP, direction);
    this.shaft.scale.set(1, shaft, 1);
    this.head.position.y = shaft;
    this.tip.copy(from).addScaledVector(direction, shaft + HEAD.length);
  }

  dispose(): void {
    this.shaft.geometry.dispose();
    this.head.geometry.dispose();
  }
}

/** A torque: an open ring around its axis, turning as the torque does. */
export class TurnArrow {
  readonly root = new Group();
  readonly tip = new Vector3();
  private readonly meshes: readonly Mesh[];

  constructor(material: Material) {
    const arc = 1.5 * Math.PI;
    const ring = new Mesh(new TorusGeometry(1, 0.06, 8, 48, arc), material);
    const head = new Mesh(new ConeGeometry(0.17, 0.45, 20), material);
    head.position.set(Math.cos(arc), Math.sin(arc), 0);
    head.rotation.z = arc;
    ring.renderOrder = head.renderOrder = 11;
    this.meshes = [ring, head];
    this.root.add(ring, head);
  }

  /** Turn about `torque` [N·m] around `centre`, as large as that is. */
  aim(centre: Vector3, torque: Vector3): void {
    const size = torque.length();
    const radius = Math.min(0.03 + 0.03 * Math.sqrt(size), 0.16);
    const axis = torque.clone().divideScalar(size);
    this.root.position.copy(centre);
    this.root.quaternion.copy(new Quaternion().setFromUnitVectors(FORWARD, axis));
    this.root.scale.setScalar(radius);
    this.tip.set(-radius, 0, 0).applyQuaternion(this.root.quaternion).add(centre);
  }

  dispose(): void {
    for (const one of this.meshes) one.geometry.dispose();
  }
}
