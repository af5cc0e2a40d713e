import { PerspectiveCamera, Vector3 } from "three";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { Mover } from "../src/scene/mover";
import type { MoveKind, Target } from "../src/moving";
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

  const offer = (kind: MoveKind) => {
    const target = { position: HERE, rpy: [0, 0, 0] as const };
    mover.offer({ name: "cube", kind, target, problem: null });
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
    offer("move");
  });

  it("drag it along themselves alone", () => {
    const [x, y, z] = HERE;
    const tip: Vector = [x, y, z + 0.1];
    point("pointermove", tip, 0);
    point("pointerdown", tip, 1);
    expect(listener.dragged).toHaveBeenLastCalledWith(true);
    point("pointermove", [x, y, z + 0.3], 1);
    const { position: moved } = listener.moved.mock.lastCall?.[0] as Target;
    expect(moved[0]).toBeCloseTo(x);
    expect(moved[1]).toBeCloseTo(y);
    expect(moved[2]).toBeCloseTo(z + 0.2, 3);
    point("pointerup", [x, y, z + 0.3], 0);
    expect(listener.dragged).toHaveBeenLastCalledWith(false);
  });

  it("rotate it as rings about the axis of the ring, in place", () => {
    offer("rotate");
    const [x, y, z] = HERE;
    // the ring about y faces the camera; three.js makes it half as large as its gizmo
    const radius = (0.5 * 0.7 * 1.9 * Math.tan(Math.PI / 12) * 2) / 4;
    const at = (angle: number): Vector => [
      x + radius * Math.sin(angle),
      y,
      z + radius * Math.cos(angle),
    ];
    point("pointermove", at(0.9), 0);
    point("pointerdown", at(0.9), 1);
    expect(listener.dragged).toHaveBeenLastCalledWith(true);
    point("pointermove", at(1.3), 1);
    const { position, rpy } = listener.moved.mock.lastCall?.[0] as Target;
    expect(position).toEqual(HERE);
    expect(Math.hypot(rpy[0], rpy[2])).toBeCloseTo(0);
    expect(rpy[1]).toBeGreaterThan(0.1);
  });

  it("are not there while nothing is to be moved", () => {
    mover.offer(null);
    const tip: Vector = [HERE[0], HERE[1], HERE[2] + 0.1];
    point("pointermove", tip, 0);
    point("pointerdown", tip, 1);
    expect(listener.dragged).not.toHaveBeenCalledWith(true);
  });
});
