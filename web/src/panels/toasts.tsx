import { t } from "../i18n";
import { dismiss, toasts } from "../notices";
import type { Toast } from "../notices";
import { Button, IconButton } from "../ui/button";
import { CloseIcon, ErrorIcon, InfoIcon, WarningIcon } from "../ui/icons";

export const SEVERITY_ICONS = {
  info: InfoIcon,
  warning: WarningIcon,
  error: ErrorIcon,
};

export function Toasts() {
  const [errors, others] = [
    toasts.value.filter((toast) => toast.severity === "error"),
    toasts.value.filter((toast) => toast.severity !== "error"),
  ];
  return (
    <section class="toasts" aria-label={t("notices.label")}>
      <div role="status" aria-live="polite">
        {others.map((toast) => (
          <ToastView key={toast.key} toast={toast} />
        ))}
      </div>
      <div role="alert" aria-live="assertive">
        {errors.map((toast) => (
          <ToastView key={toast.key} toast={toast} />
        ))}
      </div>
    </section>
  );
}

function ToastView({ toast }: { toast: Toast }) {
  const Icon = SEVERITY_ICONS[toast.severity];
  return (
    <div
      class={`toast ${toast.severity}`}
      data-testid="notice"
      data-severity={toast.severity}
    >
      <Icon />
      <span class="visually-hidden">{t(`severity.${toast.severity}`)}: </span>
      <div class="toast-body">
        <p>{toast.text}</p>
        {toast.actions.length > 0 && (
          <div class="row wrap">
            {toast.actions.map(({ name, label, run }) => (
              <Button key={name} data-testid={`notice-${name}`} onClick={run}>
                {label}
              </Button>
            ))}
          </div>
        )}
      </div>
      {toast.count > 1 && <span class="count">×{toast.count}</span>}
      <IconButton
        label={t("notices.dismiss")}
        onClick={() => {
          dismiss(toast.key);
        }}
      >
        <CloseIcon />
      </IconButton>
    </div>
  );
}
