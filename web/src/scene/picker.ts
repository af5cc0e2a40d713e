/** The object under the pointer. */
import {
  type Camera,
  type Intersection,
  type Object3D,
  type Plane,
  Raycaster,
  Vector2,
  Vector3,
} from "three";

export interface Hit {
  link?: string;
  object?: string;
  point: Vector3;
  /** Of the surface, outwards. */
  normal: Vector3;
}

export class Picker {
  private readonly ray = new Raycaster();
  private readonly pointer = new Vector2();

  constructor(
    private readonly canvas: HTMLElement,
    private readonly camera: Camera,
  ) {}

  /** Return the visible object at a point of the window [px]. */
  at(x: number, y: number, among: Object3D[]): Hit | undefined {
    this.aim(x, y);
    const [hit] = this.ray.intersectObjects(among, true);
    if (!hit) return undefined;
    const { link, object } = hit.object.userData as Partial<Record<string, string>>;
    return {
      point: hit.point,
      normal: normalOf(hit),
      ...(link !== undefined && { link }),
      ...(object !== undefined && { object }),
    };
  }

  /** Return where a point of the window [px] is on a plane; undefined if it is beside it. */
  on(plane: Plane, x: number, y: number): Vector3 | undefined {
    this.aim(x, y);
    return this.ray.ray.intersectPlane(plane, new Vector3()) ?? undefined;
  }

  private aim(x: number, y: number): void {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    this.pointer.set(((x - left) / width) * 2 - 1, 1 - ((y - top) / height) * 2);
    this.ray.setFromCamera(this.pointer, this.camera);
  }
}

function normalOf({ face, object }: Intersection): Vector3 {
  return face
    ? face.normal.clone().transformDirection(object.matrixWorld)
    : new Vector3(0, 0, 1);
}
