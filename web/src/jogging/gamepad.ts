/** A gamepad: while its left shoulder button is held, it moves the tool and the gripper. */
import { signal } from "@preact/signals";
import { sendRequest } from "../connection";
import { mayMove } from "../driving";
import type { Direction } from "../jog";
import { offers, view } from "../store";
import { arm } from "../tool";
import { jogDevice, NEUTRAL } from "./device";

const INTERVAL_MS = 16;
/** Deflection of a stick that counts as none. */
const DEAD = 0.12;
/** Buttons of the standard mapping: https://w3c.github.io/gamepad/#remapping */
const [CLOSE, OPEN] = [0, 1];
const DEAD_MAN = 4;
const [DOWN, UP] = [6, 7];
const [LEFT, RIGHT] = [14, 15];

/** The connected gamepad: with another layout than the standard one it is not used. */
export interface ConnectedGamepad {
  name: string;
  isUsed: boolean;
}

/** Null without one. */
export const gamepad = signal<ConnectedGamepad | null>(null);

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
  if (button(DEAD_MAN) < 0.5) return NEUTRAL;
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

interface GripperButtons {
  /** Grip at a press that was not there at the last look. */
  follow: (pad: Pick<Gamepad, "buttons">) => void;
  /** The gamepad, or the page, is away: a button that is held then does nothing. */
  leave: () => void;
}

function gripperButtons(): GripperButtons {
  const held = new Set([CLOSE, OPEN]);
  const leave = () => {
    held.add(CLOSE).add(OPEN);
  };
  const follow = ({ buttons }: Pick<Gamepad, "buttons">) => {
    if (document.hidden) leave();
    const isDown = (index: number) => (buttons[index]?.value ?? 0) >= 0.5;
    for (const index of [CLOSE, OPEN]) {
      if (!isDown(index)) held.delete(index);
      else if (!held.has(index)) {
        held.add(index);
        if (isDown(DEAD_MAN)) grip(index === OPEN);
      }
    }
  };
  return { follow, leave };
}

/** Open or close the gripper of the arm that is jogged. */
function grip(isOpening: boolean): void {
  const gripper = view
    .peek()
    ?.robot.grippers.find(({ name }) => name === arm.peek()?.gripper);
  if (!gripper || !mayMove.peek() || !offers("grip")) return;
  const opening = isOpening ? gripper.max_opening : 0;
  void sendRequest("grip", { gripper: gripper.name, opening });
}

function show(pad: Gamepad | null, isUsed: boolean): void {
  const shown = gamepad.peek();
  if (shown?.name === pad?.id && shown?.isUsed === (pad ? isUsed : undefined)) return;
  gamepad.value = pad && { name: pad.id, isUsed };
}

/** Follow the first gamepad of the standard mapping; call the result to end that. */
export function watchGamepad(): () => void {
  const device = jogDevice("gamepad");
  const gripper = gripperButtons();
  const leave = () => {
    device.leave();
    gripper.leave();
  };
  let last: number | undefined;
  const poll = () => {
    const there = navigator.getGamepads().filter((pad) => pad?.connected === true);
    const used = there.find((pad) => pad?.mapping === "standard");
    if (used?.index !== last) leave();
    last = used?.index;
    show(used ?? there[0] ?? null, used !== undefined);
    if (used) {
      device.follow(directionOf(used));
      gripper.follow(used);
    }
  };
  const timer = setInterval(poll, INTERVAL_MS);
  document.addEventListener("visibilitychange", leave);
  return () => {
    clearInterval(timer);
    document.removeEventListener("visibilitychange", leave);
    leave();
    gamepad.value = null;
  };
}
