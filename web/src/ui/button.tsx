import type { ComponentChildren, JSX } from "preact";

type Native = Omit<JSX.IntrinsicElements["button"], "icon" | "class">;

interface ButtonProps extends Native {
  kind?: "default" | "primary" | "danger" | "ghost";
  class?: string;
  "data-testid"?: string;
  children: ComponentChildren;
}

export function Button({ kind = "default", class: extra = "", ...rest }: ButtonProps) {
  return <button type="button" class={`button ${kind} ${extra}`} {...rest} />;
}

interface IconButtonProps extends Native {
  /** What it does, for the tooltip and for screen readers. */
  label: string;
  kind?: "default" | "ghost";
  "data-testid"?: string;
  children: ComponentChildren;
}

export function IconButton({ label, kind = "ghost", ...rest }: IconButtonProps) {
  return (
    <button
      type="button"
      class={`button icon-only ${kind}`}
      aria-label={label}
      title={label}
      {...rest}
    />
  );
}
