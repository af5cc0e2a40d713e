/** Arrows and rings at the tool: they drag it to another pose. */
import {
  type Camera,
  Object3D,
  type PerspectiveCamera,
  Quaternion,
  Vector3,
} from "three";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import type { Pose, Rotation } from "../kinematics";
import { quaternionOf, rotationOf } from "./orientation";
import type { Colours } from "./stage";

const ARROWS = 0.62;
const RINGS = 0.8;

interface Listener {
  changed: () => void;
  dragged: (is: boolean) => void;
  moved: (pose: Pose) => void;
}

/** Its handle has the axes of the chosen frame; what it turns by, the tool turns by. */
export class ToolGizmo {
  readonly root = new Object3D();
  private readonly handle = new Object3D();
  private readonly arrows: TransformControls;
  private readonly rings: TransformControls;
  private readonly axes = new Quaternion();
  /** Of the tool when the drag began, in the handle. */
  private readonly grip = new Quaternion();
  private readonly tool = new Quaternion();
  private isShown = false;

  constructor(
    private readonly camera: PerspectiveCamera,
    canvas: HTMLElement,
    private readonly listener: Listener,
  ) {
    this.arrows = this.made(camera, canvas, "translate", ARROWS);
    this.rings = this.made(camera, canvas, "rotate", RINGS);
    this.rings.showE = this.rings.showXYZE = false;
    // only one of both may be grabbed
    this.arrows.addEventListener("axis-changed", ({ value }) => {
      this.rings.enabled = value === null;
    });
    this.rings.addEventListener("axis-changed", ({ value }) => {
      this.arrows.enabled = value === null || this.arrows.axis !== null;
    });
    this.root.add(this.handle, this.arrows.getHelper(), this.rings.getHelper());
  }

  paint({ x, y, z, highlight }: Colours): void {
    this.arrows.setColors(x, y, z, highlight);
    this.rings.setColors(x, y, z, highlight);
  }

  private made(
    camera: Camera,
    canvas: HTMLElement,
    mode: "translate" | "rotate",
    size: number,
  ): TransformControls {
    const controls = new TransformControls(camera, canvas);
    controls.setMode(mode);
    controls.setSpace("local");
    controls.setSize(size);
    controls.addEventListener("change", this.listener.changed);
    controls.addEventListener("dragging-changed", ({ value }) => {
      this.listener.dragged(value === true);
      if (value !== true) this.handle.quaternion.copy(this.axes);
      else this.grip.copy(this.handle.quaternion).invert().multiply(this.tool);
    });
    controls.addEventListener("objectChange", () => {
      this.listener.moved(this.pose());
    });
    return controls;
  }

  /** Where its z arrow can be grabbed [m]. */
  get arrow(): Vector3 {
    const { size } = this.arrows;
    const { position, quaternion } = this.handle;
    // as TransformControls scales it
    const lens = this.camera;
    const wide = 1.9 * Math.tan((Math.PI * lens.fov) / 360);
    const length = (0.4 * size * wide * position.distanceTo(lens.position)) / 4;
    return new Vector3(0, 0, length).applyQuaternion(quaternion).add(position);
  }

  get isDragging(): boolean {
    return this.arrows.dragging || this.rings.dragging;
  }

  get isHovered(): boolean {
    return this.isShown && (this.arrows.axis !== null || this.rings.axis !== null);
  }

  /** Show it at the tool's pose with the axes of a frame, or hide it. */
  show(pose: Pose | null, axes: Rotation): void {
    if (this.isDragging) return;
    if (pose === null) {
      if (!this.isShown) return;
      this.isShown = false;
      this.arrows.detach();
      this.rings.detach();
      this.listener.changed();
      return;
    }
    this.tool.copy(quaternionOf(pose.R));
    this.axes.copy(quaternionOf(axes));
    this.handle.position.set(...pose.p);
    this.handle.quaternion.copy(this.axes);
    if (this.isShown) return;
    this.isShown = true;
    this.arrows.attach(this.handle);
    this.rings.attach(this.handle);
    this.listener.changed();
  }

  /** Return the pose that the tool is dragged to. */
  private pose(): Pose {
    const { x, y, z } = this.handle.position;
    this.tool.copy(this.handle.quaternion).multiply(this.grip).normalize();
    return { p: [x, y, z], R: rotationOf(this.tool) };
  }

  dispose(): void {
    this.arrows.dispose();
    this.rings.dispose();
  }
}
