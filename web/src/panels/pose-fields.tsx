/** The position and orientation of an object, as numbers. */
import { t } from "../i18n";
import type { Target } from "../moving";
import { frameName, meantTarget, shownTarget } from "../number-frame";
import { VectorField } from "../ui/vector-field";
import { angleUnit, MILLIMETRES, unitOf } from "../units";

/** The range that the server accepts [m]. */
const FARTHEST = 1000;

/** Fields for a pose in the root, or in the frame of the link that is given. */
export function PoseFields(props: {
  value: Target;
  link?: string | null;
  testId: string;
  onChange: (value: Target) => void;
}) {
  const { link = null, testId } = props;
  const value = link === null ? shownTarget(props.value) : props.value;
  const frame = link ?? frameName();
  const onChange = (changed: Target) => {
    props.onChange(link === null ? meantTarget(changed) : changed);
  };
  return (
    <>
      <VectorField
        label={t("frame.in", { what: t("objects.position"), frame })}
        unit={MILLIMETRES}
        min={-FARTHEST}
        max={FARTHEST}
        value={value.position}
        data-testid={`${testId}-position`}
        onCommit={(position) => {
          onChange({ ...value, position });
        }}
      />
      <VectorField
        label={t("frame.in", { what: t("objects.rotation"), frame })}
        axes={["roll", "pitch", "yaw"]}
        unit={unitOf("revolute", angleUnit.value)}
        min={-2 * Math.PI}
        max={2 * Math.PI}
        value={value.rpy}
        data-testid={`${testId}-rotation`}
        onCommit={(rpy) => {
          onChange({ ...value, rpy });
        }}
      />
    </>
  );
}
