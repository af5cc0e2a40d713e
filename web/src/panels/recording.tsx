/** Recording to a file: a button, and how long and how large the recording is. */
import { sendRequest } from "../connection";
import { t } from "../i18n";
import type { RecordingInfo } from "../protocol";
import { megabytes } from "../recording";
import { status } from "../store";
import { IconButton } from "../ui/button";
import { RecordIcon, StopIcon } from "../ui/icons";

export function RecordButton() {
  const recording = status.value?.recording ?? null;
  if (recording?.is_recording !== true) {
    return (
      <span class="recording">
        <IconButton
          label={t("recording.start")}
          data-testid="record-start"
          onClick={() => void sendRequest("start_recording")}
        >
          <RecordIcon />
        </IconButton>
      </span>
    );
  }
  return (
    <span
      class="recording is-recording"
      title={t("recording.file", { file: recording.file })}
    >
      <IconButton
        label={t("recording.stop")}
        data-testid="record-stop"
        onClick={() => void sendRequest("stop_recording")}
      >
        <StopIcon />
      </IconButton>
      <span class="recording-progress" data-testid="record-progress">
        {progress(recording)}
      </span>
    </span>
  );
}

function progress(recording: RecordingInfo): string {
  const { seconds } = recording;
  const rest = String(seconds % 60).padStart(2, "0");
  return t("recording.progress", {
    time: `${String(Math.floor(seconds / 60))}:${rest}`,
    size: megabytes(recording),
  });
}
