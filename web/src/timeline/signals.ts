/** The signals of a recording: its server reads them, and thins them where they are dense. */
import { computed, effect, untracked } from "@preact/signals";
import { connection } from "../connection";
import { shown } from "../frames";
import { model } from "../model";
import { report } from "../notices";
import { signalsOf } from "../plots/catalogue";
import { live } from "../plots/live";
import {
  type Samples,
  type SignalInfo,
  type SignalSource,
  source,
} from "../plots/signals";
import { view } from "../store";

/** How much more than what is visible is fetched, on either side. */
const MARGIN = 0.5;
/** No sample is left out of so many. */
const ALL = 1_000_000;

interface Fetched {
  readonly from: number;
  readonly to: number;
  readonly samples: Samples;
}

/** The signals that the recording has. */
const signals = computed<ReadonlyMap<string, SignalInfo>>(() => {
  const info = view.value;
  const known = new Set(info?.replay?.signals);
  if (!info || known.size === 0) return new Map();
  const objects = [...known].flatMap((id) => /^object\/(.*)\/x$/.exec(id)?.[1] ?? []);
  const all = signalsOf(info, model.value, objects);
  return new Map([...all].filter(([id]) => known.has(id)));
});

export class RecordedSource implements SignalSource {
  readonly signals = signals;
  private readonly listeners = new Set<() => void>();
  /** By the signals that were read together. */
  private readonly fetched = new Map<string, Fetched>();
  private readonly fetching = new Set<string>();
  /** Grows with every recording. */
  private generation = 0;

  span(): readonly [number, number] | null {
    const replay = view.peek()?.replay;
    return replay ? [replay.start, replay.end] : null;
  }

  now(): number {
    return shown.latest?.time ?? this.span()?.[0] ?? 0;
  }

  need(): () => void {
    return () => undefined; // a recording has what it has
  }

  read(ids: readonly string[], from: number, to: number, points: number): Samples {
    const key = ids.join("\n");
    const found = this.fetched.get(key);
    if (!found || !serves(found, from, to, this.span())) {
      void this.fetch(key, ids, from, to, points);
    }
    return found
      ? part(found.samples, from, to)
      : { times: [], values: ids.map(() => []) };
  }

  async exact(ids: readonly string[], from: number, to: number): Promise<Samples> {
    const answer = await this.ask(ids, from, to, ALL);
    return answer ? within(answer, from, to) : { times: [], values: ids.map(() => []) };
  }

  listen(listener: () => void): () => void {
    this.listeners.add(listener);
    const end = shown.listen(listener);
    return () => {
      end();
      this.listeners.delete(listener);
    };
  }

  held(): SignalSource {
    return this;
  }

  /** Forget what was fetched: it may be another recording. */
  clear(): void {
    this.generation += 1;
    this.fetched.clear();
    this.fetching.clear();
    this.announce();
  }

  /** Fetch a range and some more; the listeners then read again. */
  private async fetch(
    key: string,
    ids: readonly string[],
    from: number,
    to: number,
    points: number,
  ): Promise<void> {
    if (this.fetching.has(key) || ids.length === 0) return;
    this.fetching.add(key);
    const { generation } = this;
    const more = MARGIN * (to - from);
    const range = { from: from - more, to: to + more };
    const samples = await this.ask(
      ids,
      range.from,
      range.to,
      Math.ceil((1 + 2 * MARGIN) * points),
    );
    if (generation !== this.generation) return;
    this.fetching.delete(key);
    if (!samples) return;
    this.fetched.set(key, { ...range, samples });
    this.announce();
  }

  private announce(): void {
    for (const listener of this.listeners) listener();
  }

  private async ask(
    ids: readonly string[],
    from: number,
    to: number,
    points: number,
  ): Promise<Samples | null> {
    const answer = await connection.ask("read_replay", {
      signals: [...ids],
      start: Math.max(0, from),
      end: Math.max(0, to),
      points,
    });
    if (answer.problem === null) return answer.result;
    report("error", answer.problem.message);
    return null;
  }
}

/** Whether what was fetched covers a range, about as densely as that would be fetched. */
function serves(
  { from, to }: Fetched,
  wantedFrom: number,
  wantedTo: number,
  span: readonly [number, number] | null,
): boolean {
  const [start, end] = span ?? [-Infinity, Infinity];
  const covers = Math.max(wantedFrom, start) >= from && Math.min(wantedTo, end) <= to;
  return covers && to - from <= 4 * (wantedTo - wantedFrom);
}

/** Return the samples of a range, and the nearest on either side. */
function part({ times, values }: Samples, from: number, to: number): Samples {
  let first = times.findIndex((time) => time >= from);
  first = first < 0 ? Math.max(0, times.length - 1) : Math.max(0, first - 1);
  const after = times.findIndex((time) => time > to);
  const end = after < 0 ? times.length : after + 1;
  return {
    times: times.slice(first, end),
    values: values.map((row) => row.slice(first, end)),
  };
}

function within({ times, values }: Samples, from: number, to: number): Samples {
  const is = (_: unknown, i: number) => {
    const time = times[i] ?? NaN;
    return time >= from && time <= to;
  };
  return { times: times.filter(is), values: values.map((row) => row.filter(is)) };
}

const recorded = new RecordedSource();

effect(() => {
  source.value = view.value?.mode === "replay" ? recorded : live;
  untracked(() => {
    recorded.clear();
  });
});
