/** A motion that the server has planned: where joints and tool are on it.  Pure. */
import { linkPose } from "../kinematics";
import type { Plan } from "../protocol";
import type { UrdfModel, Vector } from "../urdf";

/** Joint → position [rad]. */
export type Posture = Readonly<Record<string, number>>;

/** Of the line that shows the way of the tool. */
const POINTS = 100;

export function durationOf({ times }: Plan): number {
  return times.at(-1) ?? 0;
}

/** Return where the joints are at a time of the plan [s]: quintics between its knots. */
export function postureAt(plan: Plan, time: number): Posture {
  const { times, positions, velocities, accelerations, joint_names: names } = plan;
  const next = times.findIndex((knot) => knot > time);
  const last = next < 0 ? times.length - 1 : Math.max(1, next);
  const first = Math.max(0, last - 1);
  const [begin = 0, end = 0] = [times[first], times[last]];
  const h = end - begin;
  const s = h > 0 ? Math.min(1, Math.max(0, (time - begin) / h)) : 1;
  const at = (rows: readonly number[][], k: number, i: number) => rows[k]?.[i] ?? 0;
  return Object.fromEntries(
    names.map((name, i) => {
      const [p0, p1] = [at(positions, first, i), at(positions, last, i)];
      const [v0, v1] = [at(velocities, first, i) * h, at(velocities, last, i) * h];
      const [a0, a1] = [
        at(accelerations, first, i) * h * h,
        at(accelerations, last, i) * h * h,
      ];
      const d = p1 - p0 - v0 - a0 / 2;
      const e = v1 - v0 - a0;
      const f = a1 - a0;
      const high =
        10 * d -
        4 * e +
        f / 2 +
        s * (-15 * d + 7 * e - f + s * (6 * d - 3 * e + f / 2));
      return [name, p0 + s * (v0 + s * (a0 / 2 + s * high))];
    }),
  );
}

/** Return where the plan begins. */
export function startOf(plan: Plan): Posture {
  return postureAt(plan, 0);
}

/** Return where the plan ends. */
export function endOf(plan: Plan): Posture {
  return postureAt(plan, durationOf(plan));
}

/**
 * Return the way of a link in the root [m].
 *
 * `elsewhere` has the positions of the joints that the plan does not move [rad | m].
 */
export function pathOf(
  plan: Plan,
  model: UrdfModel,
  link: string,
  elsewhere: (joint: string) => number | undefined,
): readonly Vector[] {
  return Array.from({ length: POINTS + 1 }, (_, k) => {
    const q = postureAt(plan, (durationOf(plan) * k) / POINTS);
    return linkPose(model, link, (joint) => q[joint] ?? elsewhere(joint)).p;
  });
}
