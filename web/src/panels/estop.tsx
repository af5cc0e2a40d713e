/** The emergency stop: one button that is always in view, and Escape, which only engages. */
import { sendRequest } from "../connection";
import { t } from "../i18n";
import { view, status } from "../store";
import { EmergencyIcon } from "../ui/icons";

function hasEmergencyStop(): boolean {
  return view.value?.mode === "simulation";
}

export function engageOnEscape(event: KeyboardEvent): void {
  if (event.key !== "Escape" || event.repeat || event.isComposing) return;
  if (hasEmergencyStop()) void sendRequest("emergency_stop", { engaged: true });
}

export function EmergencyStop() {
  if (!hasEmergencyStop()) return null;
  const engaged = status.value?.stopped ?? false;
  const long = t(engaged ? "estop.releaseLong" : "estop.engageLong");
  return (
    <button
      type="button"
      class={`estop ${engaged ? "engaged" : ""}`}
      aria-label={long}
      title={long}
      data-testid="estop"
      data-engaged={engaged}
      onClick={() => void sendRequest("emergency_stop", { engaged: !engaged })}
    >
      <EmergencyIcon />
      {t(engaged ? "estop.release" : "estop.engage")}
    </button>
  );
}
