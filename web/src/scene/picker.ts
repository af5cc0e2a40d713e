/** The object under the pointer. */
import { type Camera, type Object3D, Raycaster, Vector2, type Vector3 } from "three";

export interface Hit {
  link?: string;
  object?: string;
  point: Vector3;
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
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    this.pointer.set(((x - left) / width) * 2 - 1, 1 - ((y - top) / height) * 2);
    this.ray.setFromCamera(this.pointer, this.camera);
    const [hit] = this.ray.intersectObjects(among, true);
    if (!hit) return undefined;
    const { link, object } = hit.object.userData as Partial<Record<string, string>>;
    return {
      point: hit.point,
      ...(link !== undefined && { link }),
      ...(object !== undefined && { object }),
    };
  }
}
