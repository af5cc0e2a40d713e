/** The robot's tree, read from the URDF that the server names. */
import { effect, signal } from "@preact/signals";
import { serverUrl } from "./address";
import { view } from "./store";
import { parseUrdf } from "./urdf";
import type { UrdfModel } from "./urdf";

export const model = signal<UrdfModel | null>(null);
/** The source of `model`; it is set just before. */
export const urdfText = signal("");
/** Why there is no model. */
export const modelFailure = signal<string | null>(null);

async function load(path: string, aborted: AbortSignal): Promise<void> {
  try {
    const answer = await fetch(serverUrl(path), { signal: aborted });
    if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
    const text = await answer.text();
    urdfText.value = text;
    model.value = parseUrdf(text);
    modelFailure.value = null;
  } catch (reason) {
    if (aborted.aborted) return;
    model.value = null;
    modelFailure.value = reason instanceof Error ? reason.message : String(reason);
  }
}

/** Read the URDF after every view, since the robot may have changed; call the result to end it. */
export function watchModel(): () => void {
  return effect(() => {
    const path = view.value?.robot.urdf;
    if (path === undefined) return undefined;
    const abort = new AbortController();
    void load(path, abort.signal);
    return () => {
      abort.abort();
    };
  });
}
