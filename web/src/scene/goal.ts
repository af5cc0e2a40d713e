/** When there is a commanded goal worth showing.  Pure. */
import type { JointInfo } from "../protocol";

/**
 * Less than this is no goal but an error: an effort controller without an integral holds
 * an elbow some 10 mrad from its setpoint.
 */
const NOTICEABLE = { revolute: 0.025, continuous: 0.025, prismatic: 0.004 };

/**
 * Return the targets of the joints, joint → position, or undefined if they are reached.
 *
 * Joints without a target stay where they are; those that mimic another are left out,
 * since they follow it.
 */
export function goalOf(
  joints: readonly JointInfo[],
  positions: ArrayLike<number>,
  targets: Readonly<Record<string, number>>,
): Map<string, number> | undefined {
  const goal = new Map<string, number>();
  let differs = false;
  for (const [index, joint] of joints.entries()) {
    if (joint.mimics !== null) continue;
    const present = positions[index] ?? 0;
    const target = targets[joint.name] ?? present;
    goal.set(joint.name, target);
    if (Math.abs(target - present) > NOTICEABLE[joint.type]) differs = true;
  }
  return differs ? goal : undefined;
}
