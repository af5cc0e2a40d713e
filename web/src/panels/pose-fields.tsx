/** The position and orientation of an object, as numbers. */
import { t } from "../i18n";
import type { Target } from "../moving";
import { VectorField } from "../ui/vector-field";
import { angleUnit, MILLIMETRES, unitOf } from "../units";

/** The range that the server accepts [m]. */
const FARTHEST = 1000;

export function PoseFields(props: {
  value: Target;
  testId: string;
  onChange: (value: Target) => void;
}) {
  const { value, testId, onChange } = props;
  return (
    <>
      <VectorField
        label={t("objects.position")}
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
        label={t("objects.rotation")}
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
