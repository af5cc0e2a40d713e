/** A button that acts after it was held for a second, by pointer or key: never by accident. */
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { whileHeld } from "./held";

export const HOLD_MS = 1000;

interface HoldButtonProps {
  onHeld: () => void;
  "data-testid"?: string;
  children: ComponentChildren;
}

export function HoldButton({ onHeld, ...rest }: HoldButtonProps) {
  const timer = useRef<ReturnType<typeof setTimeout>>(undefined);
  const [isHeld, setHeld] = useState(false);
  const end = () => {
    clearTimeout(timer.current);
    setHeld(false);
  };
  const begin = () => {
    end();
    setHeld(true);
    timer.current = setTimeout(() => {
      end();
      onHeld();
    }, HOLD_MS);
  };
  useEffect(
    () => () => {
      clearTimeout(timer.current);
    },
    [],
  );
  return (
    <button
      type="button"
      class={`button hold ${isHeld ? "held" : ""}`}
      {...whileHeld(begin, end)}
      {...rest}
    />
  );
}
