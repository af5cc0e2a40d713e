/** Why sliders cannot drive a controller, in the page's language if there is a translation. */
import { t } from "../i18n";
import type { ControllerInfo } from "../protocol";

/** Return why a controller cannot be driven now, or null if it can. */
export function obstacle(controller: ControllerInfo): string | null {
  const { type, role, state, is_running, undrivable } = controller;
  if (undrivable === null && is_running) return null;
  if (role === "reader") return t("motion.onlyReads");
  if (role !== "trajectory") {
    return t("motion.wrongType", { type: type.slice(type.lastIndexOf("/") + 1) });
  }
  if (state === "unloaded") return t("motion.notLoaded");
  return is_running ? undrivable : t("motion.notRunning");
}

/** Return the text under the chosen controller; null if it can be driven. */
export function advice(controller: ControllerInfo): string | null {
  const why = obstacle(controller);
  if (why === null || controller.is_running) return why;
  return t("motion.startIt", { name: controller.name });
}
