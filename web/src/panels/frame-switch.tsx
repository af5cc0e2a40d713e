import { t } from "../i18n";
import { arm, chosenFrame, FRAMES } from "../tool";
import { SignalChoice } from "../ui/choice";

/** Chooses the frame of all numbers; `testId` tells the switches of the page apart. */
export function FrameSwitch({ testId }: { testId: string }) {
  if (arm.value === null) return null;
  return (
    <SignalChoice
      label={t("frame.choose")}
      of={chosenFrame}
      among={FRAMES}
      name={(value) => t(`tool.frame.${value}`)}
      testId={testId}
    />
  );
}
