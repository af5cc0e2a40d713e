/** Arrows that drag an object to another place. */
import { type Camera, Object3D } from "three";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import type { Target } from "../moving";
import type { Vector } from "../urdf";

const SIZE = 0.7;

interface Listener {
  /** It looks different. */
  changed: () => void;
  /** The user grabbed or released it. */
  dragged: (is: boolean) => void;
  /** It was dragged to [m]. */
  moved: (position: Vector) => void;
}

export class Mover {
  readonly root: Object3D;
  private readonly handle = new Object3D();
  private readonly controls: TransformControls;

  constructor(camera: Camera, canvas: HTMLElement, listener: Listener) {
    this.controls = new TransformControls(camera, canvas);
    this.controls.setSize(SIZE);
    this.root = new Object3D();
    this.root.add(this.handle, this.controls.getHelper());
    this.controls.addEventListener("change", listener.changed);
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      listener.dragged(value === true);
    });
    this.controls.addEventListener("objectChange", () => {
      const { x, y, z } = this.handle.position;
      listener.moved([x, y, z]);
    });
  }

  /** Show the arrows for this object, or hide them. */
  offer(target: Target | null): void {
    if (target === null) {
      this.controls.detach();
    } else {
      this.handle.position.set(...target.position);
      this.controls.attach(this.handle);
    }
  }

  dispose(): void {
    this.controls.dispose();
  }
}
