/** The time line under the 3D view: scrub, play, and jump to what happened. */
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { shown } from "../frames";
import { t } from "../i18n";
import { useLive } from "../live";
import { view } from "../store";
import { Button, IconButton } from "../ui/button";
import { PauseIcon, PlayIcon } from "../ui/icons";
import { Select } from "../ui/select";
import { LoopIcon, NextIcon, PreviousIcon } from "./icons";
import { addKeys } from "./keys";
import type { Player } from "./player";
import { jump, past, player, SPEEDS } from "./state";
import { Track } from "./track";
import "./timeline.css";

/** Between updates of the ends and the marks while time runs [ms]. */
const RENEWED_MS = 500;

export default function Timeline() {
  const renewed = useSignal(0);
  useEffect(() => past.watch(), []);
  useEffect(addKeys, []);
  useEffect(() => {
    const timer = setInterval(() => {
      if (player.peek().isLive) renewed.value += 1;
    }, RENEWED_MS);
    return () => {
      clearInterval(timer);
    };
  }, []);
  if (view.value === null || view.value.mode === "view") return null;
  return <Bar now={player.value} renewed={renewed.value} />;
}

function Bar({ now, renewed }: { now: Player; renewed: number }) {
  const isPlaying = now.isPlaying.value;
  return (
    <section
      class="timeline"
      aria-label={t("timeline.title")}
      data-testid="timeline"
      data-past={shown.isPast.value}
      data-live={now.isLive && !shown.isPast.value}
    >
      <div class="timeline-buttons">
        <IconButton
          label={t("timeline.previous")}
          aria-keyshortcuts="["
          data-testid="timeline-previous"
          onClick={() => {
            jump(-1);
          }}
        >
          <PreviousIcon />
        </IconButton>
        <IconButton
          label={t(isPlaying ? "timeline.pause" : "timeline.play")}
          data-testid="timeline-play"
          onClick={() => {
            now.play(!isPlaying);
          }}
        >
          {isPlaying ? <PauseIcon /> : <PlayIcon />}
        </IconButton>
        <IconButton
          label={t("timeline.next")}
          aria-keyshortcuts="]"
          data-testid="timeline-next"
          onClick={() => {
            jump(1);
          }}
        >
          <NextIcon />
        </IconButton>
      </div>
      <Track now={now} renewed={renewed} />
      <Clock now={now} />
      <Speed now={now} />
      <Mode now={now} />
    </section>
  );
}

/** The time that is shown, and how far back that is. */
function Clock({ now }: { now: Player }) {
  const time = useRef<HTMLSpanElement>(null);
  const rest = useRef<HTMLSpanElement>(null);
  useLive((frame) => {
    if (!time.current || !rest.current) return;
    const { end } = now.range();
    const back = end - now.position();
    const isLive = now.isLive && !shown.isPast.peek();
    const away = now.isLive ? `−${back.toFixed(1)} s` : `/ ${end.toFixed(2)} s`;
    time.current.textContent = `${frame.time.toFixed(2)} s`;
    rest.current.textContent = isLive ? "" : ` ${away}`;
  });
  return (
    <output class="timeline-clock" data-testid="timeline-time">
      <span class="timeline-now" ref={time} />
      <span ref={rest} />
    </output>
  );
}

function Speed({ now }: { now: Player }) {
  const speed = now.speed.value;
  const offered = new Set<number>(SPEEDS).add(speed);
  return (
    <Select
      label={t("timeline.speed")}
      value={String(speed)}
      data-testid="timeline-speed"
      options={[...offered]
        .sort((a, b) => a - b)
        .map((value) => ({ value: String(value), label: `${String(value)}×` }))}
      onChange={(value) => {
        now.setSpeed(Number(value));
      }}
    />
  );
}

/** Back to the present; or, for a recording, whether it starts again at its end. */
function Mode({ now }: { now: Player }) {
  if (now.loops === null) {
    const isPast = shown.isPast.value;
    return (
      <Button
        kind={isPast ? "primary" : "ghost"}
        aria-pressed={!isPast}
        data-testid="timeline-live"
        title={t("timeline.liveExplain")}
        onClick={() => {
          past.goLive();
        }}
      >
        <span class="timeline-dot" />
        {t("timeline.live")}
      </Button>
    );
  }
  const loops = now.loops.value;
  return (
    <IconButton
      label={t("timeline.loop")}
      aria-pressed={loops}
      data-testid="timeline-loop"
      onClick={() => {
        now.setLoops?.(!loops);
      }}
    >
      <LoopIcon />
    </IconButton>
  );
}
