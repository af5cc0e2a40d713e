/**
 * The most important states, as long as they last.  They lie over the 3D view below the bar: what
 * appears must not move a control that the pointer is about to press.
 */
import type { ComponentChildren } from "preact";
import { connection, sendRequest } from "../connection";
import { boxes, PROTECTIVE_STOP } from "../control-box";
import type { ControlBox } from "../control-box";
import { t } from "../i18n";
import type { StallInfo } from "../protocol";
import { ownerOf, robots, withoutPrefix } from "../robots";
import { silence } from "../silence";
import { connectionState, joints, offers, status } from "../store";
import { Button } from "../ui/button";
import { HoldButton } from "../ui/hold-button";
import { EmergencyIcon, ErrorIcon, WarningIcon } from "../ui/icons";
import { fixed } from "../ui/number-field";
import { stopRequested } from "./estop";

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
  const silent = silence.value;
  if (silent !== null) {
    return (
      <Banner tone="danger" testId="silence-banner">
        <WarningIcon />
        <span>{t("connection.silentBanner", { seconds: silent.toFixed(1) })}</span>
      </Banner>
    );
  }
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

function EmergencyBanner() {
  if (status.value?.stopped === true) {
    return (
      <Banner tone="danger" testId="estop-banner">
        <EmergencyIcon />
        <span>{t("estop.banner")}</span>
        {offers("emergency_stop") && (
          <HoldButton
            data-testid="estop-release"
            onHeld={() => void sendRequest("emergency_stop", { engaged: false })}
          >
            {t("estop.release")}
          </HoldButton>
        )}
      </Banner>
    );
  }
  if (!stopRequested.value) return null;
  return (
    <Banner tone="danger" testId="stop-requested">
      <EmergencyIcon />
      <span>{t("estop.requested")}</span>
    </Banner>
  );
}

/** An arm that its safety system has stopped, or somebody's request. */
function ProtectiveStopBanner({ box }: { box: ControlBox }) {
  const { arm, protective_stop: reason } = box;
  const key = robots.value.length > 0 ? "box.stoppedArm" : "box.stopped";
  return (
    <Banner tone="danger" testId="protective-stop-banner">
      <WarningIcon />
      <span>{t(key, { arm, reason })}</span>
      {offers("unlock_protective_stop") && (
        <Button
          data-testid={`unlock-${arm}`}
          onClick={() => void sendRequest("unlock_protective_stop", { arm })}
        >
          {t("box.unlock")}
        </Button>
      )}
    </Banner>
  );
}

/** A joint that pushes at its effort limit and does not move. */
function StallBanner({ stall }: { stall: StallInfo }) {
  const type = joints.value.find((joint) => joint.name === stall.joint)?.type;
  const unit = type === "prismatic" ? "N" : "N·m";
  const [first] = stall.contacts;
  const robot = ownerOf(stall.joint);
  const values = {
    joint: robot ? `${robot.name}: ${withoutPrefix(stall.joint, robot)}` : stall.joint,
    effort: `${fixed(Math.abs(stall.effort), 0)} ${unit}`,
  };
  const contacts = stall.contacts.map((pair) => pair.join(" – ")).join(", ");
  return (
    <Banner tone="warning" testId="stall-banner">
      <WarningIcon />
      <span>
        {first
          ? t("stall.against", { ...values, other: first[1], contacts })
          : t("stall.free", values)}
      </span>
    </Banner>
  );
}

export function Banners() {
  const now = status.value;
  return (
    <div class="banners">
      <ConnectionBanner />
      <EmergencyBanner />
      {boxes.value
        .filter(({ safety_mode }) => safety_mode === PROTECTIVE_STOP)
        .map((box) => (
          <ProtectiveStopBanner key={box.arm} box={box} />
        ))}
      {now !== null && now.fault !== null && (
        <Banner tone="danger" testId="fault-banner">
          <ErrorIcon />
          <span>{t("simulation.fault", { reason: now.fault })}</span>
        </Banner>
      )}
      {now?.stalls.map((stall) => (
        <StallBanner key={stall.joint} stall={stall} />
      ))}
    </div>
  );
}
