/** A part of the page that is loaded after the controls are there. */
import type { ComponentType } from "preact";
import { useEffect, useState } from "preact/hooks";
import { t } from "../i18n";

interface LazyProps {
  load: () => Promise<{ default: ComponentType }>;
}

export function Lazy({ load }: LazyProps) {
  const [part, setPart] = useState<{ default: ComponentType } | null>(null);
  const [failure, setFailure] = useState<string | null>(null);

  useEffect(() => {
    load().then(setPart, (reason: unknown) => {
      setFailure(String(reason));
    });
  }, [load]);

  if (part) return <part.default />;
  return (
    <p class="placeholder">
      {failure === null
        ? t("app.loading")
        : t("app.loadingFailed", { reason: failure })}
    </p>
  );
}
