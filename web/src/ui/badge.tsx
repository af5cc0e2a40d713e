import type { ComponentChildren } from "preact";

export type Tone = "neutral" | "ok" | "accent" | "warning" | "danger";

export function Badge(props: {
  tone?: Tone;
  children: ComponentChildren;
  "data-testid"?: string;
}) {
  return (
    <span class={`badge ${props.tone ?? "neutral"}`} data-testid={props["data-testid"]}>
      {props.children}
    </span>
  );
}
