/** Jogging by a gamepad: while its left shoulder button is held, the sticks move the tool. */
import { signal } from "@preact/signals";
import { hold, release } from "../jog";
import type { Direction } from "../jog";

const SOURCE = "gamepad";
const INTERVAL_MS = 16;
/** Deflection of a stick that counts as none. */
const DEAD = 0.12;
/** Buttons of the standard mapping: https://w3c.github.io/gamepad/#remapping */
const DEAD_MAN = 4;
const [DOWN, UP] = [6, 7];
const [LEFT, RIGHT] = [14, 15];

/** The name of the connected gamepad; null without one. */
export const gamepad = signal<string | null>(null);

/** Return the deflection of a stick without its dead zone, fine near the middle. */
export function shaped(deflection: number): number {
  const beyond = Math.max(0, Math.abs(deflection) - DEAD) / (1 - DEAD);
  return Math.sign(deflection) * Math.min(1, beyond) ** 2;
}

/** Return where a gamepad moves the tool; zeros unless its dead-man button is held. */
export function directionOf({
  axes,
  buttons,
}: Pick<Gamepad, "axes" | "buttons">): Direction {
  const button = (index: number) => buttons[index]?.value ?? 0;
  if (button(DEAD_MAN) < 0.5) return [0, 0, 0, 0, 0, 0];
  const stick = (index: number) => shaped(axes[index] ?? 0);
  return [
    -stick(1),
    -stick(0),
    button(UP) - button(DOWN),
    stick(2),
    -stick(3),
    button(LEFT) - button(RIGHT),
  ].map((share) => share + 0) as unknown as Direction;
}

/** Follow the first gamepad; call the result to end that. */
export function watchGamepad(): () => void {
  const timer = setInterval(() => {
    const found = navigator.getGamepads().find((pad) => pad?.connected === true);
    gamepad.value = found?.id ?? null;
    if (found && !document.hidden) hold(SOURCE, directionOf(found));
    else release(SOURCE);
  }, INTERVAL_MS);
  return () => {
    clearInterval(timer);
    release(SOURCE);
    gamepad.value = null;
  };
}
