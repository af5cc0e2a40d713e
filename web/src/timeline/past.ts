/** Scrolling back through the last minutes of a running robot; all of it is in this page. */
import { effect, signal } from "@preact/signals";
import { frames, shown } from "../frames";
import { t } from "../i18n";
import { moving } from "../moving";
import type { GripperState, Notice } from "../protocol";
import { isSameOverrun } from "../repeats";
import { notices, pastScene, scene, status, view } from "../store";
import { History } from "./history";
import { kindOf, type Marker } from "./markers";
import type { Player, Range } from "./player";

/** Nearer to the end than this is the present [s]. */
const PRESENT = 0.02;
/** After a longer pause the display was off: it counts as this [s]. */
const LONGEST_STEP = 0.25;
const GRIPS: readonly GripperState["motion"][] = [
  "holding_inside",
  "holding_outside",
  "blocked",
];

export class Past implements Player {
  readonly isLive = true;
  /** Whether what is shown moves: it does not, while a moment of the past is. */
  readonly isPlaying = signal(true);
  readonly speed = signal(1);
  readonly loops = null;
  readonly markers = signal<readonly Marker[]>([]);
  readonly history: History;
  private at = 0;
  private request = 0;
  private playedAt = 0;
  private lastNotice = 0;
  private overrun: Notice | undefined;
  private readonly gripping = new Map<string, boolean>();

  constructor(history = new History()) {
    this.history = history;
  }

  /** Watch the robot; call the result to end the watch. */
  watch(): () => void {
    const ends = [
      effect(() => {
        // another robot, or a new server, whose past is not known
        if (view.value !== null) this.forget();
      }),
      frames.listen((frame) => {
        this.history.push(frame, scene.peek(), performance.now());
      }),
      effect(() => {
        this.takeNotices();
      }),
      effect(() => {
        this.takeGrips(status.value?.grippers ?? []);
      }),
    ];
    return () => {
      this.goLive();
      for (const end of ends) end();
    };
  }

  range(): Range {
    return { start: this.history.start, end: this.history.end };
  }

  position(): number {
    if (!shown.isPast.peek()) return this.history.end;
    return Math.max(this.at, this.history.start);
  }

  seek(at: number): void {
    const { start, end } = this.range();
    const moment = this.history.moment(at);
    if (!moment || at >= end - PRESENT) {
      this.goLive();
      return;
    }
    if (!shown.isPast.peek()) this.isPlaying.value = false;
    this.at = Math.max(at, start);
    moving.value = null;
    pastScene.value = moment.scene;
    shown.show(moment.frame);
  }

  /** Show the present again. */
  goLive(): void {
    this.isPlaying.value = true;
    cancelAnimationFrame(this.request);
    if (!shown.isPast.peek()) return;
    pastScene.value = null;
    shown.show(null);
  }

  /** Show the past at `speed` from here on; or keep what is shown while time runs on. */
  play(isPlaying: boolean): void {
    cancelAnimationFrame(this.request);
    if (!shown.isPast.peek()) {
      if (!isPlaying) this.seek(this.history.end - 2 * PRESENT);
      return;
    }
    this.isPlaying.value = isPlaying;
    if (!isPlaying) return;
    this.playedAt = performance.now();
    this.request = requestAnimationFrame(this.step);
  }

  setSpeed(speed: number): void {
    this.speed.value = speed;
  }

  private readonly step = (now: number): void => {
    const passed = Math.min(LONGEST_STEP, Math.max(0, now - this.playedAt) / 1000);
    this.playedAt = now;
    const at = this.position() + passed * this.speed.peek();
    this.seek(at);
    if (shown.isPast.peek() && this.isPlaying.peek())
      this.request = requestAnimationFrame(this.step);
  };

  private forget(): void {
    this.goLive();
    this.history.clear();
    this.markers.value = [];
    this.lastNotice = 0;
    this.overrun = undefined;
    this.gripping.clear();
  }

  private takeNotices(): void {
    const fresh = notices.value.filter(({ number }) => number > this.lastNotice);
    let found: Marker[] = [];
    let lastTime = -Infinity;
    for (const notice of fresh) {
      this.lastNotice = notice.number;
      const isRepeated = isSameOverrun(notice, this.overrun);
      if (notice.code === "overrun") this.overrun = notice;
      const kind = kindOf(notice);
      if (kind === null || notice.time === null || isRepeated) continue;
      // before a reset that this page has not seen: nothing is known of it
      if (notice.code === "reset" && notice.time < lastTime) found = [];
      lastTime = notice.time;
      found.push({ at: this.history.placeOf(notice.time), kind, text: notice.text });
    }
    this.add(found);
  }

  private takeGrips(grippers: readonly GripperState[]): void {
    for (const { name, motion } of grippers) {
      const is = GRIPS.includes(motion);
      if (is && this.gripping.get(name) === false) {
        const text = t("timeline.grips", { name });
        this.add([{ at: this.history.end, kind: "contact", text }]);
      }
      this.gripping.set(name, is);
    }
  }

  private add(found: readonly Marker[]): void {
    if (found.length === 0) return;
    const { start } = this.history;
    const kept = this.markers.peek().filter(({ at }) => at >= start);
    this.markers.value = [...kept, ...found].sort((a, b) => a.at - b.at);
  }
}
