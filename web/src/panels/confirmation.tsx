/**
 * Asks before irreversible actions.  It is not a modal dialog: the emergency stop stays
 * usable.
 */
import { signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../i18n";
import { Button } from "../ui/button";

/** The second click of a double click does not confirm. */
const READY_AFTER_MS = 400;

interface Question {
  readonly text: string;
  /** The label of the confirming button. */
  readonly action: string;
  readonly act: () => void;
}

const question = signal<Question | null>(null);

/** Ask, and act if the user confirms. */
export function confirm(text: string, action: string, act: () => void): void {
  question.value = { text, action, act };
}

export function Confirmation() {
  const now = question.value;
  const root = useRef<HTMLDivElement | null>(null);
  const [isReady, setReady] = useState(false);
  useEffect(() => {
    const before = document.activeElement;
    root.current?.querySelector("button")?.focus();
    setReady(false);
    const timer = setTimeout(() => {
      setReady(true);
    }, READY_AFTER_MS);
    return () => {
      clearTimeout(timer);
      if (before instanceof HTMLElement) before.focus();
    };
  }, [now]);
  if (now === null) return null;
  const close = () => {
    question.value = null;
  };
  return (
    <div
      class="confirmation"
      role="alertdialog"
      aria-labelledby="confirmation-text"
      data-testid="confirmation"
      ref={root}
      onKeyDown={(event) => {
        if (event.key === "Escape") close();
      }}
    >
      <p id="confirmation-text">{now.text}</p>
      <div class="row">
        <Button data-testid="confirmation-cancel" onClick={close}>
          {t("confirm.cancel")}
        </Button>
        <Button
          kind="danger"
          disabled={!isReady}
          data-testid="confirmation-act"
          onClick={() => {
            close();
            now.act();
          }}
        >
          {now.action}
        </Button>
      </div>
    </div>
  );
}
