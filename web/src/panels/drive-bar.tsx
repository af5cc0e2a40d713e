/** The switch that lets this page move the robot, above every panel. */
import { disable, enable, endReason, isDriving } from "../driving";
import { shown } from "../frames";
import { t } from "../i18n";
import { robots } from "../robots";
import { connectionState, isLive, status } from "../store";
import { Toggle } from "../ui/toggle";

function state(): string {
  const hasOne = robots.value.length === 0;
  if (isDriving.value) return t(hasOne ? "drive.on" : "drive.onAll");
  const reason = endReason.value;
  if (reason !== null) return t(`drive.ended.${reason}`);
  return t(hasOne ? "drive.off" : "drive.offAll");
}

export function DriveBar() {
  if (!isLive.value) return null;
  const isEnded = endReason.value !== null && !isDriving.value;
  return (
    <div class="drive-bar">
      <Toggle
        label={t("drive.switch")}
        checked={isDriving.value}
        disabled={
          connectionState.value !== "open" ||
          status.value?.stopped !== false ||
          shown.isPast.value
        }
        data-testid="enable-toggle"
        onChange={(checked) => {
          if (checked) enable();
          else disable();
        }}
      />
      <p
        class={`hint ${isEnded ? "ended" : ""}`}
        role="status"
        data-testid="driving-state"
      >
        {state()}
      </p>
    </div>
  );
}
