/** What the scene shows besides robot and objects; the browser keeps the choice. */
import { effect, type Signal, signal } from "@preact/signals";
import { recall, remember } from "./ui/memory";

export const OVERLAYS = ["contacts", "wrench", "inertia", "trace"] as const;
export type Overlay = (typeof OVERLAYS)[number];

function kept(name: Overlay): Signal<boolean> {
  const shown = signal(recall(`scene.${name}`, ["shown", "hidden"]) === "shown");
  effect(() => {
    remember(`scene.${name}`, shown.value ? "shown" : "hidden");
  });
  return shown;
}

export const overlays: Readonly<Record<Overlay, Signal<boolean>>> = {
  contacts: kept("contacts"),
  wrench: kept("wrench"),
  inertia: kept("inertia"),
  trace: kept("trace"),
};
