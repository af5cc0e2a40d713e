/** Demonstrations: start an episode, and say how it ended. */
import { useEffect } from "preact/hooks";
import { sendRequest } from "../connection";
import { t } from "../i18n";
import { register } from "../shortcuts";
import { status } from "../store";
import { Button } from "../ui/button";

const OUTCOMES = ["success", "failure", "discard"] as const;
const KEYS = { success: "Shift+y", failure: "Shift+n", discard: "Shift+x" } as const;
const START = "Shift+r";

function isRecording(): boolean {
  return status.peek()?.episodes?.is_recording === true;
}

function start(): void {
  void sendRequest("start_episode");
}

function end(outcome: (typeof OUTCOMES)[number]): void {
  void sendRequest("end_episode", { outcome });
}

export default function Episodes() {
  useEffect(
    () =>
      register(
        {
          keys: [START],
          text: "episodes.startKey",
          group: "general",
          run: start,
          when: () => !isRecording(),
        },
        ...OUTCOMES.map((outcome) => ({
          keys: [KEYS[outcome]],
          text: `episodes.${outcome}Key` as const,
          group: "general" as const,
          run: () => {
            end(outcome);
          },
          when: isRecording,
        })),
      ),
    [],
  );
  const now = status.value?.episodes ?? null;
  if (now === null) return null;
  return (
    <section
      class="episodes-bar"
      aria-label={t("episodes.title")}
      data-testid="episodes"
    >
      <p class={now.error === null ? "hint" : "hint ended"} role="status">
        <strong>{now.task || t("episodes.title")}</strong>{" "}
        <span data-testid="episodes-state">
          {now.is_recording
            ? t("episodes.recording", { number: now.episodes, seconds: now.duration })
            : t("episodes.count", {
                episodes: now.episodes,
                succeeded: now.succeeded,
              })}
        </span>
        {now.error !== null && <span> {now.error}</span>}
      </p>
      <div class="buttons">
        {now.is_recording ? (
          OUTCOMES.map((outcome) => (
            <Button
              key={outcome}
              kind={outcome === "success" ? "primary" : "default"}
              title={KEYS[outcome]}
              data-testid={`episode-${outcome}`}
              onClick={() => {
                end(outcome);
              }}
            >
              {t(`episodes.${outcome}`)}
            </Button>
          ))
        ) : (
          <Button
            kind="primary"
            title={START}
            data-testid="episode-start"
            onClick={start}
          >
            {t("episodes.start")}
          </Button>
        )}
      </div>
    </section>
  );
}
