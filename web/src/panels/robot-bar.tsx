/** Which robot the controls move; nothing, if there is only one. */
import { selectRobot } from "../driving";
import { t } from "../i18n";
import type { RobotPartsInfo } from "../protocol";
import { robots, selected, stalled, titleOf } from "../robots";
import { Segmented } from "../ui/choice";
import { WarningIcon } from "../ui/icons";

function Name({ robot }: { robot: RobotPartsInfo }) {
  return (
    <>
      {robot.name}
      {stalled.value.has(robot) && (
        <span class="stalled" data-testid={`robot-stalled-${robot.name}`}>
          <WarningIcon />
        </span>
      )}
    </>
  );
}

/** For the tooltip and for screen readers. */
function describe(robot: RobotPartsInfo): string {
  const title = titleOf(robot);
  return stalled.value.has(robot) ? `${title} (${t("robots.stalled")})` : title;
}

export function RobotBar() {
  const robot = selected.value;
  if (robot === null) return null;
  return (
    <div class="robot-bar">
      <span class="caption">{t("robots.title")}</span>
      <Segmented
        label={t("robots.select")}
        value={robot.name}
        data-testid="robots"
        choices={robots.value.map((one) => ({
          value: one.name,
          label: <Name robot={one} />,
          name: describe(one),
          testId: `robot-${one.name}`,
        }))}
        onChange={selectRobot}
      />
      {robot.title !== null && <span class="hint ellipsis">{robot.title}</span>}
    </div>
  );
}
