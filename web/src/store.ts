/** The server's state, and the user's display settings.  Components only read. */
import { computed, signal } from "@preact/signals";
import type { Method } from "./messages";
import type { ViewInfo, JointInfo, Notice, ViewScene, Status } from "./protocol";

export type ConnectionState = "connecting" | "open" | "lost" | "refused" | "outdated";

// ---- state from the server; only connection.ts writes these -------------------------

export const connectionState = signal<ConnectionState>("connecting");
export const view = signal<ViewInfo | null>(null);
/** The objects around the robot. */
export const scene = signal<ViewScene | null>(null);
/** The objects of the past frame that the page shows; null: those of `scene`. */
export const pastScene = signal<ViewScene | null>(null);
/** The objects that the 3D view shows. */
export const shownScene = computed(() => pastScene.value ?? scene.value);
export const status = signal<Status | null>(null);
/** Oldest first, the last few hundred. */
export const notices = signal<readonly Notice[]>([]);

/** Whether the robot is real: what the page does moves steel. */
export const isReal = computed(() => view.value?.mode === "hardware");
/** Whether the robot has controllers, simulated or real: neither a picture nor a recording. */
export const isLive = computed(() => isReal.value || view.value?.mode === "simulation");

export const joints = computed<readonly JointInfo[]>(
  () => view.value?.robot.joints ?? [],
);
/** Joint → its place in the arrays of a frame. */
export const jointIndex = computed<ReadonlyMap<string, number>>(
  () => new Map(joints.value.map((joint, index) => [joint.name, index])),
);

// ---- what the robot offers -----------------------------------------------------------

/** Return why the robot does not offer a method; "" if it does, or is not known yet. */
export function whyMissing(method: Method): string {
  return view.value?.missing[method] ?? "";
}

/** Return whether there is a robot that offers one of these methods. */
export function offers(...methods: readonly Method[]): boolean {
  return view.value !== null && methods.some((method) => whyMissing(method) === "");
}

/** Attributes of a control of a method: disabled, with the reason, if it is not offered. */
export function unlessOffered(method: Method): { disabled?: true; title?: string } {
  const reason = whyMissing(method);
  return reason === "" ? {} : { disabled: true, title: reason };
}

// ---- the user's display settings ----------------------------------------------------

/** The link that the pointer is over, in the tree or in the scene. */
export const hoveredLink = signal<string | null>(null);
/** Links whose frames are drawn. */
export const shownFrames = signal<ReadonlySet<string>>(new Set());
export const showGhost = signal(true);
export const showCollision = signal(false);
