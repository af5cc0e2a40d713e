/** The running robot as a source of signals; it keeps the last minutes. */
import { computed, effect, type ReadonlySignal, untracked } from "@preact/signals";
import { need as needForces } from "../forces";
import { frames, shown } from "../frames";
import { model } from "../model";
import { scene, status, view } from "../store";
import { type LiveSignal, signalsOf } from "./catalogue";
import { History, type Moment } from "./history";
import { follow, removeCursors } from "./range";
import { type Samples, type SignalSource, source } from "./signals";
import { thinned } from "./thinning";

/** In a column: not computed yet. */
const PENDING = Infinity;

interface Column {
  readonly signal: LiveSignal;
  /** By the place of their moment. */
  readonly values: Float64Array;
}

export class HistorySource implements SignalSource {
  private readonly listeners = new Set<() => void>();
  /** Of signals that were read. */
  private readonly columns = new Map<string, Column>();

  constructor(
    readonly signals: ReadonlySignal<ReadonlyMap<string, LiveSignal>>,
    private readonly history: History = new History(),
    /** Return the time of the past that the page shows [s]; undefined: the present. */
    private readonly shownTime: () => number | undefined = () => undefined,
  ) {}

  push(moment: Moment): void {
    const place = this.history.push(moment);
    for (const { values } of this.columns.values()) values[place] = PENDING;
    this.announce();
  }

  /** Call the listeners. */
  announce(): void {
    for (const listener of this.listeners) listener();
  }

  /** Forget everything: it is another robot. */
  clear(): void {
    this.history.clear();
    this.columns.clear();
    this.announce();
  }

  span(): readonly [number, number] | null {
    const { history } = this;
    return history.length === 0
      ? null
      : [history.time(0), history.time(history.length - 1)];
  }

  now(): number {
    return this.shownTime() ?? this.span()?.[1] ?? 0;
  }

  need(ids: readonly string[]): () => void {
    const isForce = (id: string) => this.signals.peek().get(id)?.group === "wrench";
    return ids.some(isForce) ? needForces({ wrenches: true }) : () => undefined;
  }

  read(ids: readonly string[], from: number, to: number, points: number): Samples {
    const first = Math.max(0, this.history.firstAt(from) - 1);
    const end = Math.min(this.history.length, this.history.firstAt(to) + 1);
    return thinned(this.samples(ids, first, end), points);
  }

  exact(ids: readonly string[], from: number, to: number): Promise<Samples> {
    const first = this.history.firstAt(from);
    let end = this.history.firstAt(to);
    if (this.history.time(end) === to) end += 1;
    return Promise.resolve(this.samples(ids, first, end));
  }

  listen(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  held(): SignalSource {
    return new HistorySource(this.signals, this.history.copy(), this.shownTime);
  }

  private samples(ids: readonly string[], first: number, end: number): Samples {
    const times: number[] = [];
    for (let i = first; i < end; i++) times.push(this.history.time(i));
    const values = ids.map((id) => {
      const one = this.signals.peek().get(id);
      if (one === undefined) return times.map(() => null);
      return this.row(one, first, end);
    });
    return { times, values };
  }

  private row(one: LiveSignal, first: number, end: number): (number | null)[] {
    const values = this.column(one);
    const row: (number | null)[] = [];
    for (let i = first; i < end; i++) {
      const place = this.history.place(i);
      if (values[place] === PENDING) {
        const moment = this.history.at(i);
        values[place] = (moment && one.value(moment)) ?? NaN;
      }
      const value = values[place] ?? NaN;
      row.push(Number.isNaN(value) ? null : value);
    }
    return row;
  }

  private column(one: LiveSignal): Float64Array {
    const known = this.columns.get(one.id);
    // another signal of the same name: the robot has changed, or its model has come
    if (known?.signal === one) return known.values;
    const values = new Float64Array(this.history.capacity).fill(PENDING);
    this.columns.set(one.id, { signal: one, values });
    return values;
  }
}

/** As text, since it is then the same as long as the names are. */
const objectNames = computed(() =>
  (scene.value?.objects ?? []).map(({ name }) => name).join("\n"),
);
const signals = computed(() =>
  view.value
    ? signalsOf(view.value, model.value, objectNames.value.split("\n").filter(Boolean))
    : new Map<string, LiveSignal>(),
);

export const live = new HistorySource(signals, new History(), () =>
  shown.isPast.peek() ? shown.latest?.time : undefined,
);
source.value = live;

const moment = (frame: Moment["frame"]): Moment => ({
  frame,
  status: status.peek(),
  scene: scene.peek(),
});
const names = computed(() =>
  view.value?.robot.joints.map(({ name }) => name).join(" "),
);
effect(() => {
  if (names.value === undefined) return;
  untracked(() => {
    follow();
    removeCursors();
  });
  live.clear();
  for (const { frame } of frames.last) live.push(moment(frame));
});
frames.listen((frame) => {
  live.push(moment(frame));
});
shown.listen(() => {
  if (shown.isPast.peek()) live.announce();
});
