/** A device that tells again and again where it is deflected. */
import { hold, release } from "../jog";
import type { Direction } from "../jog";

export const NEUTRAL: Direction = [0, 0, 0, 0, 0, 0];

export interface JogDevice {
  /** Move as the device is deflected. */
  follow: (direction: Direction) => void;
  /** Stop: the device, or the page, is away. */
  leave: () => void;
}

/**
 * Return a device that moves the tool from when it has been neutral once: after the
 * start, a time away and a hidden page, a deflection that is held moves nothing.
 */
export function jogDevice(source: string): JogDevice {
  let isReady = false;
  const leave = () => {
    isReady = false;
    release(source);
  };
  const follow = (direction: Direction) => {
    const isNeutral = direction.every((share) => share === 0);
    if (document.hidden && !isNeutral) leave();
    else if (isNeutral || isReady) {
      isReady = true;
      hold(source, direction);
    }
  };
  return { follow, leave };
}
