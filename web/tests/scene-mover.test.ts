import { PerspectiveCamera, Vector3 } from "three";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { Mover } from "../src/scene/mover";
import type { Vector } from "../src/urdf";

const SIDE = 1000;
const HERE: Vector = [0.5, 0, 0.2];

describe("the arrows that move an object", () => {
  const listener = { changed: vi.fn(), dragged: vi.fn(), moved: vi.fn() };
  let camera: PerspectiveCamera;
  let canvas: HTMLCanvasElement;
  let mover: Mover;

  /** Return where a point is seen [px]. */
  const seen = (point: Vector) => {
    const { x, y } = new Vector3(...point).project(camera);
    return { clientX: ((x + 1) / 2) * SIDE, clientY: ((1 - y) / 2) * SIDE };
  };
  const point = (type: string, at: Vector, buttons: number) => {
    mover.root.updateMatrixWorld(true);
    const places = { ...seen(at), button: type === "pointermove" ? -1 : 0, buttons };
    canvas.dispatchEvent(
      new PointerEvent(type, { pointerType: "mouse", pointerId: 1, ...places }),
    );
  };

  beforeEach(() => {
    vi.resetAllMocks();
    canvas = document.createElement("canvas");
    canvas.setPointerCapture = canvas.releasePointerCapture = () => undefined;
    canvas.getBoundingClientRect = () => new DOMRect(0, 0, SIDE, SIDE);
    camera = new PerspectiveCamera(30, 1, 0.01, 60);
    camera.up.set(0, 0, 1);
    camera.position.set(0.6, -2, 0.3);
    camera.lookAt(...HERE);
    camera.updateMatrixWorld(true);
    mover = new Mover(camera, canvas, listener);
    mover.offer({ position: HERE, rpy: [0, 0, 0] });
  });

  it("drag it along themselves alone", () => {
    const [x, y, z] = HERE;
    const tip: Vector = [x, y, z + 0.1];
    point("pointermove", tip, 0);
    point("pointerdown", tip, 1);
    expect(listener.dragged).toHaveBeenLastCalledWith(true);
    point("pointermove", [x, y, z + 0.3], 1);
    const moved = listener.moved.mock.lastCall?.[0] as Vector;
    expect(moved[0]).toBeCloseTo(x);
    expect(moved[1]).toBeCloseTo(y);
    expect(moved[2]).toBeCloseTo(z + 0.2, 3);
    point("pointerup", [x, y, z + 0.3], 0);
    expect(listener.dragged).toHaveBeenLastCalledWith(false);
  });

  it("are not there while nothing is to be moved", () => {
    mover.offer(null);
    const tip: Vector = [HERE[0], HERE[1], HERE[2] + 0.1];
    point("pointermove", tip, 0);
    point("pointerdown", tip, 1);
    expect(listener.dragged).not.toHaveBeenCalledWith(true);
  });
});
