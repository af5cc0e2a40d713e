/** Whether a motion would be free, as the server says. */
import { connection } from "../connection";
import { t } from "../i18n";
import { report } from "../notices";
import type { PlanTarget } from "../protocol";
import { offers } from "../store";
import { rememberedFlag } from "../ui/memory";

/** How near a jogged arm may come to something [m]. */
const CLEARANCE = 0.005;

/** Whether jogging, and the sliders of the joints, stop in front of obstacles. */
export const stopsAtObstacles = rememberedFlag("obstacles", ["ignored", "stop"]);

interface Look {
  /** Whether the tool moves on a straight line; otherwise the joints do. */
  readonly isStraight?: boolean;
  /** Smallest distance between bodies [m]; negative: how deep they may press. */
  readonly clearance: number;
}

/** Return which bodies an arm would bring too near to each other on its way, or null. */
export async function obstacleTo(
  target: PlanTarget,
  { isStraight = false, clearance }: Look,
): Promise<string | null> {
  if (!offers("check_motion")) return null;
  const answer = await connection.ask("check_motion", {
    target,
    linear: isStraight,
    clearance,
  });
  // a target that the motion itself will refuse, or an engine that cannot tell
  if (answer.problem !== null || answer.result.is_free) return null;
  return answer.result.reason ?? "";
}

/** Return what a jogged arm would come too near to on its way, or null. */
export function obstacleAhead(target: PlanTarget): Promise<string | null> {
  return obstacleTo(target, { clearance: CLEARANCE });
}

/** Tell the user in front of what the arm stops. */
export function reportStop(obstacle: string): void {
  report("warning", t("jog.obstacle", { obstacle }));
}
