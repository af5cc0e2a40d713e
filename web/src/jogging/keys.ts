/** Jogging by the keyboard: while Shift is held, letters move the tool. */
import { halt, hold, release } from "../jog";
import type { Direction } from "../jog";
import { isTyping, register } from "../shortcuts";

const SOURCE = "keyboard";

function along(axis: number, sign: 1 | -1): Direction {
  const at = (i: number) => (i === axis ? sign : 0);
  return [at(0), at(1), at(2), at(3), at(4), at(5)];
}

/** `KeyboardEvent.code`, so that the keys are where they are on any layout. */
export const KEYS: Readonly<Record<string, Direction>> = {
  KeyW: along(0, 1),
  KeyS: along(0, -1),
  KeyA: along(1, 1),
  KeyD: along(1, -1),
  KeyE: along(2, 1),
  KeyQ: along(2, -1),
  KeyL: along(3, 1),
  KeyJ: along(3, -1),
  KeyI: along(4, 1),
  KeyK: along(4, -1),
  KeyU: along(5, 1),
  KeyO: along(5, -1),
};

register(
  {
    keys: ["Shift + W", "S", "A", "D", "E", "Q"],
    text: "shortcuts.jogMove",
    group: "jog",
  },
  {
    keys: ["Shift + L", "J", "I", "K", "U", "O"],
    text: "shortcuts.jogTurn",
    group: "jog",
  },
);

/** Jog while Shift and a key are held; call the result to end that. */
export function watchKeys(): () => void {
  const down = new Set<string>();
  const end = () => {
    for (const code of down) release(`${SOURCE} ${code}`);
    down.clear();
  };
  const press = (event: KeyboardEvent) => {
    if (!event.shiftKey || event.ctrlKey || event.altKey || event.metaKey) return;
    const direction = KEYS[event.code];
    if (direction === undefined || isTyping(event)) return;
    event.preventDefault();
    if (event.repeat || down.has(event.code)) return;
    down.add(event.code);
    hold(`${SOURCE} ${event.code}`, direction);
  };
  const lift = (event: KeyboardEvent) => {
    if (event.key === "Shift") end();
    else if (down.delete(event.code)) release(`${SOURCE} ${event.code}`);
  };
  const blur = () => {
    end();
    halt();
  };
  window.addEventListener("keydown", press, { capture: true });
  window.addEventListener("keyup", lift, { capture: true });
  window.addEventListener("blur", blur);
  return () => {
    end();
    window.removeEventListener("keydown", press, { capture: true });
    window.removeEventListener("keyup", lift, { capture: true });
    window.removeEventListener("blur", blur);
  };
}
