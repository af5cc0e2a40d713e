import type { GripperInfo } from "../protocol";
import { isOurs } from "../robots";
import { offers, view } from "../store";
import { GripperPanel } from "./gripper";
import { PosesPanel } from "./poses";
import { RecordedPanel } from "./recorded";
import { ToolSection } from "./tool";
import { TrajectoryPanel } from "./trajectory";
import { ViewPanel } from "./view";

/** Another gripper of the same name begins with settings of its own. */
function keyOf(gripper: GripperInfo): string {
  const { name, max_opening, max_speed, max_force } = gripper;
  return [name, max_opening, max_speed, max_force].join(" ");
}

export function MotionPanel() {
  const now = view.value;
  if (now === null) return null;
  if (now.mode === "replay") return <RecordedPanel />;
  return (
    <>
      <Joints />
      <ToolSection />
      {offers("grip") &&
        now.robot.grippers
          .filter(({ joint }) => isOurs(joint))
          .map((gripper, _, ours) => (
            <GripperPanel
              key={keyOf(gripper)}
              gripper={gripper}
              isNamed={ours.length > 1}
            />
          ))}
      {offers("go_to_pose", "save_pose") && <PosesPanel />}
    </>
  );
}

/** The joints: put, steered, or only shown. */
function Joints() {
  if (offers("pose_joints")) return <ViewPanel />;
  return offers("steer_joints") ? <TrajectoryPanel /> : <RecordedPanel />;
}
