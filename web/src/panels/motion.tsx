import { isOurs } from "../robots";
import { view } from "../store";
import { GripperPanel } from "./gripper";
import { PosesPanel } from "./poses";
import { RecordedPanel } from "./recorded";
import { ToolSection } from "./tool";
import { TrajectoryPanel } from "./trajectory";
import { ViewPanel } from "./view";

export function MotionPanel() {
  const now = view.value;
  if (now === null) return null;
  if (now.mode === "replay") return <RecordedPanel />;
  return (
    <>
      {now.mode === "view" ? <ViewPanel /> : <TrajectoryPanel />}
      <ToolSection />
      {now.robot.grippers
        .filter(({ joint }) => isOurs(joint))
        .map((gripper, _, ours) => (
          <GripperPanel
            key={gripper.name}
            gripper={gripper}
            isNamed={ours.length > 1}
          />
        ))}
      <PosesPanel />
    </>
  );
}
