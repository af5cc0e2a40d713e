/** The emergency stop: a button and Escape, which only engage; its release is in the banner. */
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { sendRequest } from "../connection";
import { t } from "../i18n";
import { isLive, isReal, status, unlessOffered } from "../store";
import { EmergencyIcon } from "../ui/icons";

/** The status follows the answer within a tenth of a second; no longer wait is needed. */
const CONFIRMED_WITHIN_MS = 1000;

/** Whether this page requested the stop, and the robot's state does not show it yet. */
export const stopRequested = signal(false);

function hasEmergencyStop(): boolean {
  return isLive.value;
}

async function engage(): Promise<void> {
  stopRequested.value = status.value?.stopped !== true;
  const problem = await sendRequest("emergency_stop", { engaged: true });
  if (problem === null) {
    setTimeout(() => {
      stopRequested.value = false;
    }, CONFIRMED_WITHIN_MS);
  } else {
    stopRequested.value = false;
  }
}

function engageIfAny(): void {
  if (hasEmergencyStop()) void engage();
}

export function engageOnEscape(event: KeyboardEvent): void {
  if (event.key === "Escape" && !event.repeat && !event.isComposing) engageIfAny();
}

let isLeaving = false;

/** Leave full screen without a stop. */
export function leaveFullScreen(): void {
  isLeaving = true;
  document.exitFullscreen().catch(() => {
    isLeaving = false; // it goes on, so that Escape may still leave it
  });
}

/**
 * Browsers take Escape for themselves in full screen: whatever leaves it, but for the
 * page itself, counts as Escape.
 */
function engageOnLeaving(): void {
  if (document.fullscreenElement === null && !isLeaving) engageIfAny();
  isLeaving = false;
}

export function EmergencyStop() {
  useEffect(() => {
    document.addEventListener("fullscreenchange", engageOnLeaving);
    return () => {
      document.removeEventListener("fullscreenchange", engageOnLeaving);
    };
  }, []);
  if (!hasEmergencyStop()) return null;
  const long = t(isReal.value ? "estop.stopLong" : "estop.engageLong");
  return (
    <button
      type="button"
      class="estop"
      aria-label={long}
      title={long}
      data-testid="estop"
      data-engaged={status.value?.stopped ?? false}
      onClick={() => void engage()}
      onKeyDown={(event) => {
        if (event.repeat) event.preventDefault(); // a held Enter presses once
      }}
      {...unlessOffered("emergency_stop")}
    >
      <EmergencyIcon />
      {t(isReal.value ? "estop.stop" : "estop.engage")}
    </button>
  );
}
