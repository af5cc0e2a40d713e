/** Jogging by a SpaceMouse through WebHID, where the browser has that. */
import { signal } from "@preact/signals";
import type { Direction } from "../jog";
import { report } from "../notices";
import { jogDevice, NEUTRAL } from "./device";

/** 3Dconnexion, and Logitech, of which its older devices are. */
const FILTERS = [
  { vendorId: 0x256f, usagePage: 0x01, usage: 0x08 },
  { vendorId: 0x046d, usagePage: 0x01, usage: 0x08 },
];
/** A deflected cap reports every few milliseconds; silence for so long counts as release [ms]. */
const SILENCE_MS = 80;
/** The largest deflection, in counts. */
const FULL = 350;
const DEAD = 0.08;

/** The part of WebHID that is used here: https://wicg.github.io/webhid/ */
interface HidDevice extends EventTarget {
  readonly productName: string;
  readonly opened: boolean;
  open(): Promise<void>;
  close(): Promise<void>;
}
interface Hid extends EventTarget {
  requestDevice(options: { filters: typeof FILTERS }): Promise<HidDevice[]>;
}
interface InputReport extends Event {
  readonly reportId: number;
  readonly data: DataView;
}

/** The name of the connected device; null without one. */
export const spaceMouse = signal<string | null>(null);

function hid(): Hid | undefined {
  return (navigator as Navigator & { hid?: Hid }).hid;
}

export function hasHid(): boolean {
  return hid() !== undefined;
}

/**
 * Return the deflections in a report of translation (1), rotation (2), or both: x is
 * forward, y left and z up, where the device has x right, y towards the user and z down.
 */
export function deflections(
  reportId: number,
  data: DataView,
  before: Direction,
): Direction {
  const at = (index: number) => {
    const share = data.getInt16(2 * index, true) / FULL;
    return Math.abs(share) < DEAD ? 0 : Math.min(1, Math.max(-1, share));
  };
  const [x, y, z, rx, ry, rz] = before;
  const three = (first: number) =>
    [-at(first + 1) + 0, -at(first) + 0, -at(first + 2) + 0] as const;
  if (reportId === 1 && data.byteLength >= 12) return [...three(0), ...three(3)];
  if (reportId === 1) return [...three(0), rx, ry, rz];
  if (reportId === 2) return [x, y, z, ...three(0)];
  return before;
}

let close: (() => void) | null = null;

/** Let the user choose a device, and follow it until `disconnectSpaceMouse`. */
export async function connectSpaceMouse(): Promise<void> {
  try {
    const [device] = (await hid()?.requestDevice({ filters: FILTERS })) ?? [];
    if (device === undefined) return;
    disconnectSpaceMouse();
    if (!device.opened) await device.open();
    follow(device);
  } catch (reason) {
    report("error", String(reason)); // on Linux, the device may need a udev rule
  }
}

function follow(device: HidDevice): void {
  const jogging = jogDevice("SpaceMouse");
  const rest = () => {
    now = NEUTRAL;
    jogging.follow(now);
  };
  let now = NEUTRAL;
  let silence: ReturnType<typeof setTimeout> | undefined;
  const read = (event: Event) => {
    const { reportId, data } = event as InputReport;
    now = deflections(reportId, data, now);
    jogging.follow(now);
    clearTimeout(silence);
    silence = setTimeout(rest, SILENCE_MS);
  };
  const gone = (event: Event) => {
    if ((event as Event & { device?: HidDevice }).device === device)
      disconnectSpaceMouse();
  };
  device.addEventListener("inputreport", read);
  hid()?.addEventListener("disconnect", gone);
  spaceMouse.value = device.productName;
  rest(); // a device that says nothing is neutral
  close = () => {
    clearTimeout(silence);
    jogging.leave();
    device.removeEventListener("inputreport", read);
    hid()?.removeEventListener("disconnect", gone);
    void device.close();
  };
}

export function disconnectSpaceMouse(): void {
  close?.();
  close = null;
  spaceMouse.value = null;
}
