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
  /** Another one for each question. */
  readonly number: number;
  readonly text: string;
  /** The label of the confirming button. */
  readonly action: string;
  readonly act: () => void;
}

const question = signal<Question | null>(null);
let asked = 0;

/** Ask, and act if the user confirms. */
export function confirm(text: string, action: string, act: () => void): void {
  asked += 1;
  question.value = { number: asked, text, action, act };
}

export function Confirmation() {
  const now = question.value;
  return now === null ? null : <Dialog key={now.number} question={now} />;
}

/** One question: its button is not ready in the first picture either. */
function Dialog({ question: now }: { question: Question }) {
  const root = useRef<HTMLDivElement | null>(null);
  const [isReady, setReady] = useState(false);
  useEffect(() => {
    const before = document.activeElement;
    root.current?.querySelector("button")?.focus();
    const timer = setTimeout(() => {
      setReady(true);
    }, READY_AFTER_MS);
    return () => {
      clearTimeout(timer);
      if (before instanceof HTMLElement) before.focus();
    };
  }, []);
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
