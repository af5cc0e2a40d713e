/** Hand guiding: the button that starts it, and what belongs to it while it is on. */
import { shownBox } from "../control-box";
import { mayMove } from "../driving";
import {
  chooseFreedom,
  endGuiding,
  freedom,
  FREEDOMS,
  type Freedom,
  guided,
  pullForce,
  startGuiding,
} from "../guiding";
import type { Key } from "../i18n";
import { t } from "../i18n";
import { addWaypoint } from "../program/shortcuts";
import { offers } from "../store";
import { Button, IconButton } from "../ui/button";
import { Select } from "../ui/select";
import { HandIcon } from "./icons";

const FREEDOM_NAMES: Record<Freedom, Key> = {
  all: "guide.all",
  position: "guide.position",
  rotation: "guide.rotation",
};

export function GuideBar() {
  if (shownBox.value === null || !offers("start_freedrive")) return null;
  const isOn = guided.value !== null;
  const force = pullForce.value;
  return (
    <div class="scene-bar guide" role="group" aria-label={t("guide.title")}>
      <IconButton
        label={t(mayMove.value ? "guide.title" : "guide.needsDrive")}
        aria-pressed={isOn}
        disabled={!mayMove.value}
        data-testid="guide-toggle"
        onClick={() => void (isOn ? endGuiding() : startGuiding())}
      >
        <HandIcon />
      </IconButton>
      {isOn && (
        <>
          <Select
            label={t("guide.freedom")}
            value={freedom.value}
            options={FREEDOMS.map((value) => ({
              value,
              label: t(FREEDOM_NAMES[value]),
            }))}
            data-testid="guide-freedom"
            onChange={(value) => {
              chooseFreedom(value as Freedom);
            }}
          />
          <Button data-testid="guide-waypoint" onClick={addWaypoint}>
            {t("guide.waypoint")}
          </Button>
          <span class="guide-text" role="status" data-testid="guide-text">
            {force === null
              ? t("guide.hint")
              : t("guide.force", { force: Math.round(force) })}
          </span>
        </>
      )}
    </div>
  );
}
