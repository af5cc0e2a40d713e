/** The control boxes of the arms, and the one that the page shows. */
import { computed } from "@preact/signals";
import type { AnalogPin, ControlBoxState } from "./protocol";
import { selected } from "./robots";
import { status } from "./store";

/** The server sends every field. */
export type ControlBox = Required<ControlBoxState>;

export const boxes = computed<readonly ControlBox[]>(
  () => (status.value?.control_boxes ?? []) as ControlBox[],
);

/** The one of the selected robot; null without one. */
export const shownBox = computed<ControlBox | null>(() => {
  const robot = selected.value;
  if (robot === null) return boxes.value[0] ?? null;
  return boxes.value.find(({ arm }) => arm === robot.name) ?? null;
});

export const PROTECTIVE_STOP = 3;
export const POWER_OFF = 3;
export const IDLE = 5;

/** Whether the brakes of the arm are released, whatever its stops. */
export function isPowered({ robot_mode }: ControlBox): boolean {
  return robot_mode === 6 || robot_mode === 7;
}

export interface PinGroup {
  readonly name: "standard" | "configurable" | "tool";
  /** Number of its first pin in the lists. */
  readonly first: number;
  readonly count: number;
}

export const PIN_GROUPS: readonly PinGroup[] = [
  { name: "standard", first: 0, count: 8 },
  { name: "configurable", first: 8, count: 8 },
  { name: "tool", first: 16, count: 2 },
];

/** How an analogue pin is shown: 4 to 20 mA, or 0 to 10 V. */
export function analogScale({ domain }: AnalogPin) {
  return domain === 0
    ? { unit: "mA", factor: 1000, min: 4, max: 20 }
    : { unit: "V", factor: 1, min: 0, max: 10 };
}
