/** A path that is planned and not yet executed: the scene draws it. */
import { signal } from "@preact/signals";
import type { Vector } from "../urdf";

/** Points of tool0 in the frame of the root [m], or null for none. */
export const plannedPath = signal<readonly Vector[] | null>(null);
