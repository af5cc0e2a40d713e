/** How far a parallel gripper is open. */
import type { GripperInfo } from "./protocol";

/** Return the opening between the pads with the joint at `q` [m]. */
export function openingAt(info: GripperInfo, q: number): number {
  const { pad_offset, pad_cos, pad_sin, pad_slope } = info;
  const half = pad_offset + pad_cos * Math.cos(q) + pad_sin * Math.sin(q);
  return Math.max(0, 2 * (half + pad_slope * q));
}
