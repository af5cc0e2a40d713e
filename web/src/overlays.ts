/** What the scene shows besides robot and objects; the browser keeps the choice. */
import type { Signal } from "@preact/signals";
import { rememberedFlag } from "./ui/memory";

export const OVERLAYS = ["contacts", "wrench", "inertia", "trace"] as const;
export type Overlay = (typeof OVERLAYS)[number];

function kept(name: Overlay): Signal<boolean> {
  return rememberedFlag(`scene.${name}`, ["hidden", "shown"]);
}

export const overlays: Readonly<Record<Overlay, Signal<boolean>>> = {
  contacts: kept("contacts"),
  wrench: kept("wrench"),
  inertia: kept("inertia"),
  trace: kept("trace"),
};
