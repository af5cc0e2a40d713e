/** What is always in view while the robot is real: which one it is, and whether it may move. */
import { sendRequest } from "../connection";
import { boxes } from "../control-box";
import { t } from "../i18n";
import type { RobotLink } from "../protocol";
import { isReal } from "../store";
import { Button } from "../ui/button";
import { confirm } from "./confirmation";

function askToEnable(arm: string, link: Required<RobotLink>): void {
  const text = t("real.confirm", {
    model: link.model,
    serial: link.serial_number,
    address: link.address,
  });
  confirm(text, t("real.enable"), () => {
    void sendRequest("enable_motion", { arm, serial_number: link.serial_number });
  });
}

export function RealRobotBar() {
  const box = boxes.value[0];
  if (!isReal.value || box?.link === undefined || box.link === null) return null;
  const link = box.link as Required<RobotLink>;
  const isStopped = link.is_enabled && box.program === "STOPPED";
  const state = !link.is_connected
    ? t("real.lost")
    : t(link.is_enabled ? "real.enabled" : "real.reading");
  return (
    <aside
      class={`real-robot ${link.is_connected ? "" : "lost"}`}
      data-testid="real-robot"
      data-enabled={link.is_enabled}
      title={t("real.safety")}
    >
      <strong>{t("real.title")}</strong>
      <span>
        {link.model} {link.serial_number} · {link.address} · PolyScope {link.software}
      </span>
      <span role="status" data-testid="real-robot-state">
        {state}
        {link.is_enabled &&
          ` · ${t("real.slider", { percent: Math.round(100 * box.speed_slider) })}`}
        {box.motion_failure !== "" &&
          ` · ${t("real.stopped", { reason: box.motion_failure })}`}
        {link.gripper_problem !== "" &&
          ` · ${t("real.gripper", { reason: link.gripper_problem })}`}
      </span>
      {!link.is_enabled && link.obstacles.length > 0 && (
        <details open>
          <summary>{t("real.obstacles")}</summary>
          <ul>
            {link.obstacles.map((text) => (
              <li key={text}>{text}</li>
            ))}
          </ul>
        </details>
      )}
      {isStopped && (
        <Button
          data-testid="real-robot-play"
          onClick={() => void sendRequest("play_program", { arm: box.arm })}
        >
          {t("real.play")}
        </Button>
      )}
      {link.is_enabled ? (
        <Button
          data-testid="real-robot-disable"
          onClick={() => void sendRequest("disable_motion", { arm: box.arm })}
        >
          {t("real.disable")}
        </Button>
      ) : (
        <Button
          disabled={!link.is_connected}
          data-testid="real-robot-enable"
          onClick={() => {
            askToEnable(box.arm, link);
          }}
        >
          {t("real.enable")}
        </Button>
      )}
      <small>{t("real.safety")}</small>
    </aside>
  );
}
