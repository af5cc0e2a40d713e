/** Why sliders cannot drive a controller, in the page's language if there is a translation. */
import { t } from "../i18n";
import type { ControllerInfo } from "../protocol";

const DRIVABLE = "/JointTrajectoryController";
const READER = "/JointStateController";

/** Return why a controller cannot be driven now, or null if it can. */
export function obstacle({ type, state, undrivable }: ControllerInfo): string | null {
  if (undrivable === null && state === "running") return null;
  if (type.endsWith(READER)) return t("motion.onlyReads");
  if (!type.endsWith(DRIVABLE)) {
    return t("motion.wrongType", { type: type.slice(type.lastIndexOf("/") + 1) });
  }
  if (state === "unloaded") return t("motion.notLoaded");
  return state === "running" ? undrivable : t("motion.notRunning");
}

/** Return the text under the chosen controller; null if it can be driven. */
export function advice(controller: ControllerInfo): string | null {
  const why = obstacle(controller);
  if (why === null || controller.state === "running") return why;
  return t("motion.startIt", { name: controller.name });
}
