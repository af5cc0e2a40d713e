/** Pose and target of the tool, and jogging. */
import { offers } from "../../store";
import { JogPanel } from "./jog";
import { PosePanel } from "./pose";
import "./tool.css";

export default function ToolPanel() {
  return (
    <>
      <PosePanel />
      {offers("speed_tool") && <JogPanel />}
    </>
  );
}
