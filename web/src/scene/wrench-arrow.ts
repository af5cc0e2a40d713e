/** The external wrench on the tool of an arm: an arrow for the force, a ring for the torque. */
import { Group, MeshBasicMaterial, type Object3D, Quaternion, Vector3 } from "three";
import { Arrow, TurnArrow } from "./arrow";
import type { Label } from "./labels";

/** Smaller ones are not drawn [N], [N·m]. */
const LEAST_FORCE = 0.3;
const LEAST_TORQUE = 0.05;

type Wrench = readonly [number, number, number, number, number, number];

export class WrenchArrow {
  readonly root = new Group();
  private readonly material = new MeshBasicMaterial({
    depthTest: false,
    transparent: true,
    opacity: 0.9,
    toneMapped: false,
  });
  private readonly arrow = new Arrow(this.material);
  private readonly turn = new TurnArrow(this.material);
  private readonly centre = new Vector3();
  private text = "";

  constructor() {
    this.root.add(this.arrow.root, this.turn.root);
    this.root.visible = false;
  }

  paint(colour: string): void {
    this.material.color.set(colour);
  }

  /** Show a wrench [N, N·m] in the axes of the link `tip`, at its origin; or none. */
  show(tip: Object3D | undefined, wrench: Wrench | undefined): void {
    this.root.visible = tip !== undefined && wrench !== undefined;
    if (!tip || !wrench) return;
    const axes = tip.getWorldQuaternion(new Quaternion());
    tip.getWorldPosition(this.centre);
    const [fx, fy, fz, tx, ty, tz] = wrench;
    const force = new Vector3(fx, fy, fz).applyQuaternion(axes);
    const torque = new Vector3(tx, ty, tz).applyQuaternion(axes);
    const [pulls, turns] = [force.length(), torque.length()];
    this.arrow.root.visible = pulls >= LEAST_FORCE;
    this.turn.root.visible = turns >= LEAST_TORQUE;
    if (this.arrow.root.visible) this.arrow.aim(this.centre, force);
    if (this.turn.root.visible) this.turn.aim(this.centre, torque);
    this.text = `F ${pulls.toFixed(1)} N, τ ${turns.toFixed(2)} N·m`;
  }

  get labels(): Label[] {
    if (!this.root.visible) return [];
    const at = this.arrow.root.visible ? this.arrow.tip : this.centre;
    return [{ text: this.text, at }];
  }

  dispose(): void {
    this.arrow.dispose();
    this.turn.dispose();
    this.material.dispose();
  }
}
