/** The spring by which the pointer pulls a link of an arm that gives way. */
import {
  BufferGeometry,
  type Camera,
  Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  Plane,
  SphereGeometry,
  Vector3,
} from "three";
import { grab, guided, pullTo, release } from "../guiding";
import type { Vector } from "../urdf";
import type { Hit, Picker } from "./picker";

/** Of the balls at the ends of the spring, as a part of their distance from the camera. */
const BALL = 0.006;

/** What it needs of the scene. */
interface Surroundings {
  /** What is under a point of the window [px]. */
  at: (x: number, y: number) => Hit | undefined;
  link: (name: string) => Object3D | undefined;
  /** It looks different. */
  changed: () => void;
}

interface Held {
  readonly link: Object3D;
  /** In the link's frame [m]. */
  readonly point: Vector3;
  /** In which the pointer moves: it faces the camera. */
  readonly plane: Plane;
  readonly pointer: number;
  readonly target: Vector3;
}

export class PullSpring {
  readonly root = new Group();
  private readonly look = new LineBasicMaterial({
    depthTest: false,
    transparent: true,
  });
  private readonly ballLook = new MeshBasicMaterial({
    depthTest: false,
    transparent: true,
    toneMapped: false,
  });
  private readonly line = new Line(new BufferGeometry(), this.look);
  private readonly ball = new SphereGeometry(1, 16, 12);
  private readonly ends = [0, 1].map(() => new Mesh(this.ball, this.ballLook));
  private held: Held | undefined;

  constructor(
    private readonly canvas: HTMLElement,
    private readonly camera: Camera,
    private readonly picker: Picker,
    private readonly around: Surroundings,
  ) {
    this.root.visible = false;
    this.root.add(this.line, ...this.ends);
    this.line.frustumCulled = false;
    for (const one of this.root.children) one.renderOrder = 11;
    // before the camera's controls, which would turn the view
    canvas.addEventListener("pointerdown", this.press, { capture: true });
    canvas.addEventListener("pointermove", this.move);
    canvas.addEventListener("lostpointercapture", this.letGo);
    window.addEventListener("blur", this.letGo);
  }

  paint(colour: string): void {
    this.look.color.set(colour);
    this.ballLook.color.set(colour);
  }

  /** Draw it where the link is now. */
  follow(): void {
    const { held } = this;
    if (!held) return;
    held.link.updateWorldMatrix(true, false);
    const ends = [held.link.localToWorld(held.point.clone()), held.target];
    this.line.geometry.setFromPoints(ends);
    this.ends.forEach((ball, i) => {
      ball.position.copy(ends[i] ?? held.target);
      const distance = ball.position.distanceTo(this.camera.position);
      ball.scale.setScalar(BALL * distance);
    });
    this.around.changed();
  }

  dispose(): void {
    this.letGo();
    this.canvas.removeEventListener("pointerdown", this.press, { capture: true });
    this.canvas.removeEventListener("pointermove", this.move);
    this.canvas.removeEventListener("lostpointercapture", this.letGo);
    window.removeEventListener("blur", this.letGo);
    this.line.geometry.dispose();
    this.ball.dispose();
    this.look.dispose();
    this.ballLook.dispose();
  }

  private readonly press = (event: PointerEvent): void => {
    if (guided.peek() === null || event.button !== 0 || this.held) return;
    const hit = this.around.at(event.clientX, event.clientY);
    const link = this.around.link(hit?.link ?? "");
    if (hit?.link === undefined || !link) return;
    event.stopImmediatePropagation();
    this.canvas.setPointerCapture(event.pointerId);
    const towards = this.camera.getWorldDirection(new Vector3());
    const point = link.worldToLocal(hit.point.clone());
    this.held = {
      link,
      point,
      plane: new Plane().setFromNormalAndCoplanarPoint(towards, hit.point),
      pointer: event.pointerId,
      target: hit.point.clone(),
    };
    this.root.visible = true;
    grab(hit.link, vectorOf(point), vectorOf(hit.point));
    this.follow();
  };

  private readonly move = (event: PointerEvent): void => {
    if (event.pointerId !== this.held?.pointer) return;
    const { clientX, clientY } = event;
    const target = this.picker.on(this.held.plane, clientX, clientY);
    if (!target) return;
    this.held.target.copy(target);
    pullTo(vectorOf(target));
    this.follow();
  };

  /** The pointer was released, or belongs to something else. */
  private readonly letGo = (): void => {
    if (!this.held) return;
    this.held = undefined;
    this.root.visible = false;
    release();
    this.around.changed();
  };
}

function vectorOf({ x, y, z }: Vector3): Vector {
  return [x, y, z];
}
