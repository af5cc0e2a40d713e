/** The time line of a recording: its server plays it, for every page alike. */
import { computed, signal } from "@preact/signals";
import { connection, sendRequest } from "../connection";
import { shown } from "../frames";
import type { Notice } from "../protocol";
import { isSameOverrun } from "../repeats";
import { notices, status, view } from "../store";
import { kindOf, type Marker } from "./markers";
import type { Player, Range } from "./player";

export class Replay implements Player {
  readonly isLive = false;
  readonly isPlaying = computed(() => status.value?.paused === false);
  readonly speed = computed(() => status.value?.speed ?? 1);
  readonly loops = computed(() => status.value?.loops ?? false);
  readonly markers = computed<readonly Marker[]>(() => {
    let overrun: Notice | undefined;
    return notices.value.flatMap((notice) => {
      const isRepeated = isSameOverrun(notice, overrun);
      if (notice.code === "overrun") overrun = notice;
      const kind = kindOf(notice);
      if (kind === null || notice.time === null || isRepeated) return [];
      return [{ at: notice.time, kind, text: notice.text }];
    });
  });
  /** Where a drag is, which the server only follows. */
  private readonly wanted = signal<number | null>(null);
  private isSeeking = false;

  range(): Range {
    const { start, end } = view.peek()?.replay ?? { start: 0, end: 0 };
    return { start, end };
  }

  position(): number {
    return this.wanted.peek() ?? shown.latest?.time ?? this.range().start;
  }

  seek(at: number): void {
    const { start, end } = this.range();
    this.wanted.value = Math.min(end, Math.max(start, at));
    if (!this.isSeeking) void this.follow();
  }

  play(isPlaying: boolean): void {
    void sendRequest(isPlaying ? "resume" : "pause");
  }

  setSpeed(speed: number): void {
    void sendRequest("set_speed", { factor: speed });
  }

  setLoops(loops: boolean): void {
    void sendRequest("loop_replay", { loops });
  }

  /** Let the server seek, one request at a time, until it is where the drag is. */
  private async follow(): Promise<void> {
    this.isSeeking = true;
    for (;;) {
      const time = this.wanted.peek();
      if (time === null) break;
      const problem = await connection.request("seek_replay", { time });
      if (problem !== null || this.wanted.peek() === time) this.wanted.value = null;
    }
    this.isSeeking = false;
  }
}
