/** The server's state, and the user's display settings.  Components only read. */
import { computed, signal } from "@preact/signals";
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

export const joints = computed<readonly JointInfo[]>(
  () => view.value?.robot.joints ?? [],
);
/** Joint → its place in the arrays of a frame. */
export const jointIndex = computed<ReadonlyMap<string, number>>(
  () => new Map(joints.value.map((joint, index) => [joint.name, index])),
);

// ---- the user's display settings ----------------------------------------------------

/** The link that the pointer is over, in the tree or in the scene. */
export const hoveredLink = signal<string | null>(null);
/** Links whose frames are drawn. */
export const shownFrames = signal<ReadonlySet<string>>(new Set());
export const showGhost = signal(true);
export const showCollision = signal(false);
