/** A button that opens a small panel below it.  A click elsewhere closes it. */
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { IconButton } from "./button";

interface MenuProps {
  label: string;
  icon: ComponentChildren;
  children: ComponentChildren;
  "data-testid": string;
}

export function Menu({ label, icon, children, ...rest }: MenuProps) {
  const [isOpen, setOpen] = useState(false);
  const root = useRef<HTMLDivElement | null>(null);
  useEffect(() => {
    const close = (event: Event) => {
      if (!root.current?.contains(event.target as Node)) setOpen(false);
    };
    // Escape stops the robot, wherever it is pressed; an open menu is closed as well
    const closeOnEscape = (event: KeyboardEvent) => {
      if (event.key === "Escape") setOpen(false);
    };
    document.addEventListener("keydown", closeOnEscape);
    document.addEventListener("pointerdown", close);
    document.addEventListener("focusin", close);
    return () => {
      document.removeEventListener("keydown", closeOnEscape);
      document.removeEventListener("pointerdown", close);
      document.removeEventListener("focusin", close);
    };
  }, []);
  return (
    <div class="menu" ref={root}>
      <IconButton
        label={label}
        aria-expanded={isOpen}
        onClick={() => {
          setOpen(!isOpen);
        }}
        {...rest}
      >
        {icon}
      </IconButton>
      {isOpen && (
        <div class="menu-content" role="group" aria-label={label}>
          {children}
        </div>
      )}
    </div>
  );
}
