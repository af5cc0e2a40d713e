import { t } from "../i18n";
import { Segmented } from "../ui/choice";
import { angleUnit } from "../units";

export function UnitSwitch() {
  return (
    <Segmented
      label={t("motion.unit")}
      value={angleUnit.value}
      data-testid="unit"
      choices={[
        { value: "rad", label: "rad", testId: "unit-rad" },
        { value: "deg", label: "deg", testId: "unit-deg" },
      ]}
      onChange={(chosen) => {
        angleUnit.value = chosen;
      }}
    />
  );
}
