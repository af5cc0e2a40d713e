/** Arrows that drag an object to another place, or rings that rotate it. */
import { type Camera, Object3D } from "three";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import type { Move, Target } from "../moving";
import type { Colours } from "./stage";

const SIZE = 0.7;

interface Listener {
  /** It looks different. */
  changed: () => void;
  /** The user grabbed or released it. */
  dragged: (is: boolean) => void;
  /** It was dragged there. */
  moved: (target: Target) => void;
}

export class Mover {
  readonly root: Object3D;
  private readonly handle = new Object3D();
  private readonly controls: TransformControls;

  constructor(camera: Camera, canvas: HTMLElement, listener: Listener) {
    this.controls = new TransformControls(camera, canvas);
    this.controls.setSize(SIZE);
    // rpy turns about fixed axes: about x first, which three calls ZYX
    this.handle.rotation.order = "ZYX";
    this.root = new Object3D();
    this.root.add(this.handle, this.controls.getHelper());
    this.controls.addEventListener("change", listener.changed);
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      listener.dragged(value === true);
    });
    this.controls.addEventListener("objectChange", () => {
      const { position, rotation } = this.handle;
      listener.moved({
        position: [position.x, position.y, position.z],
        rpy: [rotation.x, rotation.y, rotation.z],
      });
    });
  }

  /** Show the handles for this object, or hide them. */
  offer(move: Move | null): void {
    if (move === null) {
      this.controls.detach();
      return;
    }
    const { kind, target } = move;
    this.handle.position.set(...target.position);
    // while it is dragged the handle is ahead
    if (!this.controls.dragging) this.handle.rotation.set(...target.rpy, "ZYX");
    this.controls.setMode(kind === "rotate" ? "rotate" : "translate");
    this.controls.attach(this.handle);
  }

  get isHovered(): boolean {
    return this.controls.axis !== null;
  }

  paint({ x, y, z, highlight }: Colours): void {
    this.controls.setColors(x, y, z, highlight);
  }

  dispose(): void {
    this.controls.dispose();
  }
}
