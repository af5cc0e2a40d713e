/** Which signals are plotted where; the browser keeps it for each robot. */
import { computed, signal } from "@preact/signals";
import { isOurController, isOurs, selected } from "../robots";
import { joints, status, view } from "../store";
import { recallText, remember } from "../ui/memory";
import { COLOURS, freeColour } from "./quantities";

export const WINDOWS = [5, 10, 30, 60, 300] as const;
const MAX_PANES = 6;

/** A signal in a pane. */
export interface Trace {
  readonly id: string;
  /** Number of its colour. */
  readonly colour: number;
}

export type Pane = readonly Trace[];
export type Layout = readonly Pane[];

/** Visible seconds. */
export const seconds = signal<number>(
  WINDOWS.find((one) => String(one) === recallText("plots.seconds")) ?? 10,
);

export function show(window: number): void {
  seconds.value = window;
  remember("plots.seconds", String(window));
}

/** The key of what the user chose for this robot. */
const key = computed(() => {
  const robot = view.value?.robot;
  return `plots/${robot?.name ?? ""}/${selected.value?.name ?? ""}`;
});
/** What the user chose during this visit, by key. */
const chosen = signal<ReadonlyMap<string, Layout>>(new Map());

/** The joints of the trajectory controller that has most, running or not, or the first three. */
const usualNames = computed(() => {
  const [controller] = (status.value?.controllers ?? [])
    .filter((one) => one.role === "trajectory" && isOurController(one))
    .sort((a, b) => b.joints.length - a.joints.length);
  const ours = joints.value.map(({ name }) => name).filter(isOurs);
  const names = controller?.joints ?? ours.slice(0, 3);
  // as text, since it is then the same as long as it says the same
  return names.slice(0, COLOURS).join("\n");
});
const usual = computed<Layout>(() => [
  usualNames.value
    .split("\n")
    .map((name, colour) => ({ id: `joint/${name}/position`, colour })),
]);

/** The panes from top to bottom, at least one. */
export const layout = computed<Layout>(
  () =>
    chosen.value.get(key.value) ??
    parseLayout(recallText(key.value) ?? "") ??
    usual.value,
);

/** Return the layout that `text` says, or undefined if it says none. */
export function parseLayout(text: string): Layout | undefined {
  let panes: unknown;
  try {
    panes = JSON.parse(text);
  } catch {
    return undefined;
  }
  if (!Array.isArray(panes) || panes.length === 0 || panes.length > MAX_PANES) {
    return undefined;
  }
  const found = panes.map((pane: unknown) =>
    Array.isArray(pane) && pane.every(isTrace) ? pane : undefined,
  );
  return found.every((pane) => pane !== undefined) ? found : undefined;
}

function isTrace(one: unknown): one is Trace {
  if (typeof one !== "object" || one === null) return false;
  const { id, colour } = one as Partial<Record<keyof Trace, unknown>>;
  const isColour = Number.isInteger(colour) && Number(colour) in Array(COLOURS).fill(0);
  return typeof id === "string" && isColour;
}

function change(next: Layout): void {
  chosen.value = new Map(chosen.value).set(key.value, next);
  remember(key.value, JSON.stringify(next));
}

function changePane(index: number, next: Pane): void {
  change(layout.value.map((pane, i) => (i === index ? next : pane)));
}

/** Plot signals in a pane, or no longer. */
export function choose(index: number, ids: readonly string[], isChosen: boolean): void {
  let pane: Pane = layout.value[index] ?? [];
  for (const id of ids) {
    const others = pane.filter((trace) => trace.id !== id);
    if (!isChosen) pane = others;
    else if (others.length === pane.length) {
      pane = [...pane, { id, colour: freeColour(pane.map(({ colour }) => colour)) }];
    }
  }
  changePane(index, pane);
}

export const canAddPane = computed(() => layout.value.length < MAX_PANES);

export function addPane(): void {
  if (canAddPane.value) change([...layout.value, []]);
}

export function removePane(index: number): void {
  const left = layout.value.filter((_pane, i) => i !== index);
  change(left.length > 0 ? left : [[]]);
}

/** Return to the joints of the controller that runs. */
export function resetLayout(): void {
  change(usual.value);
}
