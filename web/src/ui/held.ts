/** What a button does while it is held, by pointer or key: it ends whatever ends the press. */
import { uncapture } from "./pointer";

/** Return the listeners of such a button. */
export function whileHeld(begin: () => void, end: () => void) {
  return {
    onPointerDown: (event: PointerEvent & { readonly currentTarget: Element }) => {
      uncapture(event);
      if (event.button === 0) begin();
    },
    onPointerUp: end,
    onPointerLeave: end,
    onPointerCancel: end,
    onContextMenu: (event: Event) => {
      event.preventDefault(); // a long touch opens it
    },
    onKeyDown: (event: KeyboardEvent) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      if (!event.repeat) begin();
    },
    onKeyUp: end,
    onBlur: end,
  };
}
