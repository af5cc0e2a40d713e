/** The windows of the cameras that the user has opened. */
import "./cameras.css";
import { openCameras } from "./state";
import { CameraWindow } from "./window";

export default function CameraWindows() {
  return (
    <>
      {openCameras.value.map((camera, index) => (
        <CameraWindow key={camera.name} camera={camera} index={index} />
      ))}
    </>
  );
}
