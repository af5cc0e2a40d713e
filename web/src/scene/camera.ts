/** The camera, moved by pointer, keys or views. */
import { type Box3, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { distanceFor } from "./framing";

const FOV = 32;
const FLIGHT_MS = 320;
/** Margin around the framed box. */
const MARGIN = 1.06;
/** Least height of the camera above the floor [m]. */
const CLEARANCE = 0.03;
/** What an arrow key turns the view by [rad]. */
const TURN = Math.PI / 36;

interface Place {
  readonly eye: Vector3;
  readonly target: Vector3;
}

export class CameraRig {
  readonly camera = new PerspectiveCamera(FOV, 1, 0.01, 60);
  private readonly controls: OrbitControls;
  private flight: { from: Place; to: Place; start: number } | undefined;
  private dragging = false;

  /**
   * @param floor height of the ground [m], which hides what is seen from below; or null
   * @param changed called whenever the view changes
   */
  constructor(
    canvas: HTMLElement,
    private readonly floor: number | null,
    changed: () => void,
  ) {
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.minDistance = 0.08;
    this.controls.maxDistance = 25;
    this.controls.zoomToCursor = true;
    this.controls.zoomSpeed = 1.4;
    this.controls.addEventListener("change", () => {
      this.stayAboveFloor();
      changed();
    });
    this.controls.addEventListener("start", () => {
      this.flight = undefined;
      this.dragging = true;
    });
    this.controls.addEventListener("end", () => {
      this.dragging = false;
    });
  }

  /** Let the pointer turn the view, or leave it to something else. */
  set isEnabled(value: boolean) {
    this.controls.enabled = value;
  }

  get isDragging(): boolean {
    return this.dragging;
  }

  /** Direction from the target to the camera. */
  get direction(): Vector3 {
    return this.camera.position.clone().sub(this.controls.target).normalize();
  }

  resize(aspect: number): void {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
  }

  /** See the whole of `box` from `direction`. */
  frame(box: Box3, direction: Vector3, fly: boolean): void {
    const target = box.getCenter(new Vector3());
    const distance = MARGIN * distanceFor(box, direction, this.camera);
    const eye = target.clone().addScaledVector(direction, distance);
    this.go({ eye, target }, fly);
  }

  /** Look at `target`, from as far away as now. */
  focus(target: Vector3): void {
    const eye = this.camera.position.clone().add(target).sub(this.controls.target);
    this.go({ eye, target }, true);
  }

  private go(to: Place, fly: boolean): void {
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (!fly || still) {
      this.flight = undefined;
      this.place(to.eye, to.target);
      return;
    }
    const from = {
      eye: this.camera.position.clone(),
      target: this.controls.target.clone(),
    };
    this.flight = { from, to, start: performance.now() };
  }

  /** Move on with a flight; return whether there is one. */
  step(now: number): boolean {
    if (!this.flight) return false;
    const { from, to, start } = this.flight;
    const share = Math.min(1, Math.max(0, (now - start) / FLIGHT_MS));
    const eased = 1 - (1 - share) ** 3;
    const target = from.target.clone().lerp(to.target, eased);
    // the distance changes evenly too, instead of cutting the corner through the robot
    const before = from.eye.clone().sub(from.target);
    const after = to.eye.clone().sub(to.target);
    const reach = before.length() + eased * (after.length() - before.length());
    const ray = before.normalize().lerp(after.normalize(), eased);
    this.place(ray.setLength(reach).add(target), target);
    if (share === 1) this.flight = undefined;
    return this.flight !== undefined;
  }

  private stayAboveFloor(): void {
    const { camera, controls, floor } = this;
    if (floor === null) return;
    controls.target.z = Math.max(controls.target.z, floor);
    const lowest = floor + CLEARANCE;
    if (camera.position.z >= lowest) return;
    camera.position.z = lowest;
    camera.lookAt(controls.target);
  }

  private place(eye: Vector3, target: Vector3): void {
    this.camera.position.copy(eye);
    this.controls.target.copy(target);
    this.controls.update();
  }

  /** Turn or zoom by a key; return whether it was one of ours. */
  key(key: string): boolean {
    const turn = {
      ArrowLeft: [-1, 0],
      ArrowRight: [1, 0],
      ArrowUp: [0, 1],
      ArrowDown: [0, -1],
    }[key];
    const zoom = { "+": 0.85, "=": 0.85, "-": 1 / 0.85 }[key];
    if (!turn && zoom === undefined) return false;
    const { target } = this.controls;
    const arm = this.camera.position.clone().sub(target);
    const radius = arm.length() * (zoom ?? 1);
    const [around = 0, over = 0] = turn ?? [];
    const azimuth = Math.atan2(arm.y, arm.x) + around * TURN;
    const steepest = Math.PI / 2 - 1e-3;
    const elevation = Math.asin(arm.z / arm.length()) + over * TURN;
    const bounded = Math.min(steepest, Math.max(-steepest, elevation));
    arm.set(
      radius * Math.cos(bounded) * Math.cos(azimuth),
      radius * Math.cos(bounded) * Math.sin(azimuth),
      radius * Math.sin(bounded),
    );
    this.flight = undefined;
    this.place(arm.add(target), target.clone());
    return true;
  }

  dispose(): void {
    this.controls.dispose();
  }
}
