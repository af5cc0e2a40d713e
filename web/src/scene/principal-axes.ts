/** Principal moments and axes of an inertia tensor, by Jacobi's rotations.  Pure. */
import type { Rotation } from "../kinematics";
import type { Vector } from "../urdf";

type Tensor = readonly [Vector, Vector, Vector];

const PAIRS = [
  [0, 1],
  [0, 2],
  [1, 2],
] as const;
/** Each sweep squares the error. */
const SWEEPS = 12;

/** Return moments and axes, `axes` with the axis of each moment in its column. */
export function principalAxes(tensor: Tensor): { moments: Vector; axes: Rotation } {
  const a = tensor.map((row): number[] => [...row]);
  const v = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    for (const [p, q] of PAIRS) rotate(a, v, p, q);
  }
  const [x = [], y = [], z = []] = v;
  const row = (r: number[]): Vector => [r[0] ?? 0, r[1] ?? 0, r[2] ?? 0];
  return {
    moments: [a[0]?.[0] ?? 0, a[1]?.[1] ?? 0, a[2]?.[2] ?? 0],
    axes: [row(x), row(y), row(z)],
  };
}

/** Make the element (p, q) of `a` zero by a rotation in that plane. */
function rotate(a: number[][], v: number[][], p: number, q: number): void {
  const at = (m: number[][], i: number, j: number) => m[i]?.[j] ?? 0;
  const set = (m: number[][], i: number, j: number, value: number) => {
    const row = m[i];
    if (row) row[j] = value;
  };
  const off = at(a, p, q);
  if (off === 0) return;
  const theta = (at(a, q, q) - at(a, p, p)) / (2 * off);
  const t = Math.sign(theta || 1) / (Math.abs(theta) + Math.hypot(theta, 1));
  const c = 1 / Math.hypot(t, 1);
  const s = t * c;
  for (let k = 0; k < 3; k++) {
    const [kp, kq] = [at(a, k, p), at(a, k, q)];
    set(a, k, p, c * kp - s * kq);
    set(a, k, q, s * kp + c * kq);
  }
  for (let k = 0; k < 3; k++) {
    const [pk, qk] = [at(a, p, k), at(a, q, k)];
    set(a, p, k, c * pk - s * qk);
    set(a, q, k, s * pk + c * qk);
    const [vp, vq] = [at(v, k, p), at(v, k, q)];
    set(v, k, p, c * vp - s * vq);
    set(v, k, q, s * vp + c * vq);
  }
}
