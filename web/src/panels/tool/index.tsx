/** Pose and target of the tool, and jogging. */
import { view } from "../../store";
import { JogPanel } from "./jog";
import { PosePanel } from "./pose";
import "./tool.css";

export default function ToolPanel() {
  return (
    <>
      <PosePanel />
      {view.value?.mode === "simulation" && <JogPanel />}
    </>
  );
}
