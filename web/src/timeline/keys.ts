/** Keys of the time line. */
import { view } from "../store";
import { register } from "../shortcuts";
import { jump, player } from "./state";

/** Space presses a button that has the focus, and is the slider's own. */
function isSpaceFree(): boolean {
  const focused = document.activeElement;
  return (
    focused === null ||
    focused === document.body ||
    focused.closest(".timeline-track") !== null
  );
}

/** Add the keys; call the result to remove them. */
export function addKeys(): () => void {
  const when = () => view.peek() !== null && view.peek()?.mode !== "view";
  return register(
    {
      keys: ["["],
      text: "timeline.previous",
      group: "timeline",
      when,
      run: () => {
        jump(-1);
      },
    },
    {
      keys: ["]"],
      text: "timeline.next",
      group: "timeline",
      when,
      run: () => {
        jump(1);
      },
    },
    {
      keys: [" "],
      text: "timeline.playPause",
      group: "timeline",
      when: () => when() && isSpaceFree(),
      run: () => {
        const now = player.peek();
        now.play(!now.isPlaying.peek());
      },
    },
  );
}
