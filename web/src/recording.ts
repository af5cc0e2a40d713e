/** A recording that has ended: where it is, and what can be done with it. */
import { effect } from "@preact/signals";
import { serverUrl } from "./address";
import { t } from "./i18n";
import { report } from "./notices";
import type { RecordingInfo } from "./protocol";
import { status } from "./store";

/** Return the size of a recording [MB]. */
export function megabytes({ size }: RecordingInfo): string {
  return (size / 1e6).toFixed(1);
}

/** Report every recording that ends from now on; call the result to end the watch. */
export function watchRecording(): () => void {
  let isRecording = false;
  return effect(() => {
    const now = status.value?.recording ?? null;
    if (isRecording && now?.is_recording === false) reportEnd(now);
    isRecording = now?.is_recording ?? false;
  });
}

function reportEnd(recording: RecordingInfo): void {
  const { file, seconds, error } = recording;
  if (error !== null) {
    report("error", t("recording.failed", { reason: error }));
    return;
  }
  report("info", t("recording.done", { file, seconds, size: megabytes(recording) }), [
    { name: "replay", label: t("recording.replay"), run: () => void replay(file) },
    { name: "download", label: t("recording.download"), run: download },
  ]);
}

function download(): void {
  const link = document.createElement("a");
  link.href = serverUrl("/recording");
  link.download = "";
  link.click();
}

/** Let the server start a replay, and show it in another tab. */
async function replay(file: string): Promise<void> {
  // at once: later, the browser would take it for an advertisement
  const tab = window.open("", "_blank");
  const why = (reason: string) => t("recording.noReplay", { file, reason });
  try {
    const answer = await fetch(serverUrl("/recording/replay"), { method: "POST" });
    const text = (await answer.text()).trim();
    if (!answer.ok) throw new Error(text);
    if (tab) tab.location.href = text;
    else report("info", t("recording.replayAt", { address: text }));
  } catch (reason) {
    tab?.close();
    report("error", why(reason instanceof Error ? reason.message : String(reason)));
  }
}
