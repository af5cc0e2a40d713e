/** What a person must know before anything else, under the bar, as long as it is so. */
import type { ComponentChildren } from "preact";
import { connection } from "../connection";
import { t } from "../i18n";
import { connectionState, status } from "../store";
import { Button } from "../ui/button";
import { EmergencyIcon, ErrorIcon, WarningIcon } from "../ui/icons";

function Banner(props: {
  tone: "danger" | "warning";
  testId: string;
  children: ComponentChildren;
}) {
  return (
    <div
      class={`banner ${props.tone}`}
      role={props.tone === "danger" ? "alert" : "status"}
      data-testid={props.testId}
    >
      {props.children}
    </div>
  );
}

function ConnectionBanner() {
  switch (connectionState.value) {
    case "lost":
      return (
        <Banner tone="warning" testId="connection-banner">
          <WarningIcon />
          <span>{t("connection.lostBanner")}</span>
        </Banner>
      );
    case "refused":
      return (
        <Banner tone="danger" testId="connection-banner">
          <ErrorIcon />
          <span>{t("connection.refusedBanner")}</span>
          <Button
            onClick={() => {
              connection.open();
            }}
          >
            {t("connection.retry")}
          </Button>
        </Banner>
      );
    case "outdated":
      return (
        <Banner tone="danger" testId="connection-banner">
          <ErrorIcon />
          <span>{t("connection.outdatedBanner")}</span>
          <Button
            onClick={() => {
              window.location.reload();
            }}
          >
            {t("app.reload")}
          </Button>
        </Banner>
      );
    default:
      return null;
  }
}

export function Banners() {
  const now = status.value;
  return (
    <div class="banners">
      <ConnectionBanner />
      {now?.stopped === true && (
        <Banner tone="danger" testId="estop-banner">
          <EmergencyIcon />
          <span>{t("estop.banner")}</span>
        </Banner>
      )}
      {now !== null && now.fault !== null && (
        <Banner tone="danger" testId="fault-banner">
          <ErrorIcon />
          <span>{t("simulation.fault", { reason: now.fault })}</span>
        </Banner>
      )}
    </div>
  );
}
