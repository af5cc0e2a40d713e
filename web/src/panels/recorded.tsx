/** The robot of a recording: positions of its joints and grippers at the time shown. */
import { t } from "../i18n";
import { isOurs } from "../robots";
import { joints, status, view } from "../store";
import { Badge } from "../ui/badge";
import { fixed } from "../ui/number-field";
import { describeGripper } from "./gripper";
import { JointRow } from "./joint-row";
import { UnitSwitch } from "./unit-switch";

function ignore(): void {
  // nothing moves what was recorded
}

export function RecordedPanel() {
  const ours = joints.value.filter(
    ({ name, mimics }) => mimics === null && isOurs(name),
  );
  const replay = view.value?.replay;
  return (
    <>
      <section class="group" aria-labelledby="recorded-title">
        <header>
          <h2 id="recorded-title">{t("motion.joints")}</h2>
          <UnitSwitch />
        </header>
        {replay?.is_complete === false && <p class="hint">{t("replay.cutOff")}</p>}
        <ul class="joints monitor">
          {ours.map((joint) => (
            <JointRow key={joint.name} joint={joint} goal={null} onChange={ignore} />
          ))}
        </ul>
      </section>
      <Grippers />
    </>
  );
}

function Grippers() {
  const grippers = status.value?.grippers ?? [];
  if (grippers.length === 0) return null;
  return (
    <section class="group" aria-labelledby="recorded-grippers">
      <header>
        <h2 id="recorded-grippers">{t("gripper.title")}</h2>
      </header>
      <ul>
        {grippers.map((state) => (
          <li
            class="row"
            key={state.name}
            data-testid={`recorded-gripper-${state.name}`}
          >
            <code>{state.name}</code>
            <span>{fixed(1000 * state.opening, 1)} mm</span>
            <Badge tone={state.motion === "blocked" ? "warning" : "neutral"}>
              {describeGripper(state)}
            </Badge>
          </li>
        ))}
      </ul>
    </section>
  );
}
