import { view } from "../store";
import { GripperPanel } from "./gripper";
import { PosesPanel } from "./poses";
import { TrajectoryPanel } from "./trajectory";
import { ViewPanel } from "./view";

export function MotionPanel() {
  const now = view.value;
  if (now === null) return null;
  return (
    <>
      {now.mode === "view" ? <ViewPanel /> : <TrajectoryPanel />}
      {now.robot.grippers.map((gripper) => (
        <GripperPanel key={gripper.name} gripper={gripper} />
      ))}
      <PosesPanel />
    </>
  );
}
