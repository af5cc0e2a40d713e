/** What the server said, and how this person wants to see it.  Components only read. */
import { computed, signal } from "@preact/signals";
import type { ViewInfo, JointInfo, Notice, ViewScene, Status } from "./protocol";

export type ConnectionState = "connecting" | "open" | "lost" | "refused" | "outdated";

// ---- said by the server; only connection.ts writes these ----------------------------

export const connectionState = signal<ConnectionState>("connecting");
export const view = signal<ViewInfo | null>(null);
/** What is around the robot now. */
export const scene = signal<ViewScene | null>(null);
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

// ---- how this person wants to see it ------------------------------------------------

/** The link that the pointer is over, in the tree or in the scene. */
export const hoveredLink = signal<string | null>(null);
/** Links whose frames are drawn. */
export const shownFrames = signal<ReadonlySet<string>>(new Set());
export const showGhost = signal(true);
export const showCollision = signal(false);
