/** Changes of signals. */
import type { ReadonlySignal } from "@preact/signals";

/**
 * Call a function at each change of a signal, but not for its present value: a module
 * that is loaded late must not undo what others began; return what ends that.
 */
export function onChange<T>(of: ReadonlySignal<T>, act: () => void): () => void {
  let last = of.peek();
  return of.subscribe((now) => {
    if (now === last) return;
    last = now;
    act();
  });
}
