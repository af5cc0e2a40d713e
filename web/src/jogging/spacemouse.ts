/** Jogging by a SpaceMouse through WebHID, where the browser has that. */
import { signal } from "@preact/signals";
import { hold, release } from "../jog";
import type { Direction } from "../jog";
import { report } from "../notices";

const SOURCE = "SpaceMouse";
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

/** Return the deflections in a report of translation (1), rotation (2), or both. */
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
  // the device has y towards the user and z down
  if (reportId === 1 && data.byteLength >= 12) {
    return [at(0), -at(1) + 0, -at(2) + 0, at(3), -at(4) + 0, -at(5) + 0];
  }
  if (reportId === 1) return [at(0), -at(1) + 0, -at(2) + 0, rx, ry, rz];
  if (reportId === 2) return [x, y, z, at(0), -at(1) + 0, -at(2) + 0];
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
  let now: Direction = [0, 0, 0, 0, 0, 0];
  let silence: ReturnType<typeof setTimeout> | undefined;
  const read = (event: Event) => {
    const { reportId, data } = event as InputReport;
    now = deflections(reportId, data, now);
    clearTimeout(silence);
    if (document.hidden) {
      release(SOURCE);
      return;
    }
    hold(SOURCE, now);
    silence = setTimeout(() => {
      now = [0, 0, 0, 0, 0, 0];
      release(SOURCE);
    }, SILENCE_MS);
  };
  const gone = (event: Event) => {
    if ((event as Event & { device?: HidDevice }).device === device)
      disconnectSpaceMouse();
  };
  device.addEventListener("inputreport", read);
  hid()?.addEventListener("disconnect", gone);
  spaceMouse.value = device.productName;
  close = () => {
    clearTimeout(silence);
    device.removeEventListener("inputreport", read);
    hid()?.removeEventListener("disconnect", gone);
    void device.close();
  };
}

export function disconnectSpaceMouse(): void {
  close?.();
  close = null;
  release(SOURCE);
  spaceMouse.value = null;
}
