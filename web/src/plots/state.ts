/** The state of the plots; like the recording, it outlives the drawer. */
import { computed, effect, signal } from "@preact/signals";
import { frames } from "../frames";
import { isOurController, isOurs, selected } from "../robots";
import { jointIndex, joints, status } from "../store";
import { angleUnit } from "../units";
import { COLOURS, freeColour, type Plotted, scaleOf } from "./quantities";
import { Recording } from "./recording";
import type { Line } from "./series";

export const WINDOWS = [5, 10, 30, 60] as const;

export const plotted = signal<Plotted>("position");
/** Visible seconds. */
export const seconds = signal<number>(10);
/** The frozen recording while the robot continues; null: the present. */
export const frozen = signal<Recording | null>(null);
type Colours = ReadonlyMap<string, number>;

/** Robot, or "" for a single one → what the user chose of it. */
const chosen = signal<ReadonlyMap<string, Colours>>(new Map());
const robotKey = computed(() => selected.value?.name ?? "");

/** The joints of the first trajectory controller that runs, or the first three; one a line. */
const usualNames = computed(() => {
  const running = status.value?.controllers.find(
    (one) => one.is_running && one.role === "trajectory" && isOurController(one),
  );
  const ours = joints.value.map(({ name }) => name).filter(isOurs);
  const names = running?.joints ?? ours.slice(0, 3);
  // as text, since it is then the same as long as it says the same
  return names.slice(0, COLOURS).join("\n");
});
const usual = computed<Colours>(
  () => new Map(usualNames.value.split("\n").map((name, index) => [name, index])),
);

/** Joint → number of its colour. */
export const colours = computed(() => chosen.value.get(robotKey.value) ?? usual.value);

export const lines = computed<readonly Line[]>(() =>
  joints.value.flatMap((joint) => {
    const colour = colours.value.get(joint.name);
    const index = jointIndex.value.get(joint.name);
    if (colour === undefined || index === undefined) return [];
    const scale = scaleOf(plotted.value, joint.type, angleUnit.value);
    return [{ joint, index, colour, scale }];
  }),
);

export function choose(name: string, isChosen: boolean): void {
  const next = new Map(colours.value);
  if (isChosen) next.set(name, freeColour(next.values()));
  else next.delete(name);
  chosen.value = new Map(chosen.value).set(robotKey.value, next);
}

/** The recording of this robot's joints. */
export const recording = signal(new Recording(0));
const names = computed(() => joints.value.map(({ name }) => name).join(" "));
effect(() => {
  // other joints: another robot
  if (names.value === "") return;
  recording.value = new Recording(joints.peek().length);
  for (const { frame } of frames.last) recording.peek().push(frame);
  frozen.value = null;
  chosen.value = new Map();
});
frames.listen((frame) => {
  recording.peek().push(frame);
});

export function freeze(isFrozen: boolean): void {
  frozen.value = isFrozen ? recording.peek().copy() : null;
}
