/** The switch that lets this page move the robot, above every panel. */
import { disable, enable, endReason, isDriving } from "../driving";
import { t } from "../i18n";
import { connectionState, status, view } from "../store";
import { Toggle } from "../ui/toggle";

function state(): string {
  if (isDriving.value) return t("drive.on");
  const reason = endReason.value;
  return reason === null ? t("drive.off") : t(`drive.ended.${reason}`);
}

export function DriveBar() {
  if (view.value?.mode !== "simulation") return null;
  const isEnded = endReason.value !== null && !isDriving.value;
  return (
    <div class="drive-bar">
      <Toggle
        label={t("drive.switch")}
        checked={isDriving.value}
        disabled={connectionState.value !== "open" || status.value?.stopped !== false}
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
