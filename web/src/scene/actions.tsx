/** Buttons over the picture that concern the whole page: a picture, full screen, help. */
import { useEffect, useState } from "preact/hooks";
import { t } from "../i18n";
import { leaveFullScreen } from "../panels/estop";
import { toggleShortcutHelp } from "../panels/shortcut-help";
import { view } from "../store";
import { IconButton } from "../ui/button";
import { save } from "../ui/download";
import { CameraIcon, FullScreenIcon, KeyboardIcon } from "../ui/icons";
import type { Viewer } from "./viewer";

export function Actions({ viewer }: { viewer: Viewer }) {
  return (
    <div class="scene-bar actions">
      <IconButton
        label={t("layout.screenshot")}
        data-testid="scene-screenshot"
        onClick={() => void takePicture(viewer)}
      >
        <CameraIcon />
      </IconButton>
      <FullScreen />
      <IconButton
        label={t("layout.shortcuts")}
        data-testid="shortcuts"
        onClick={toggleShortcutHelp}
      >
        <KeyboardIcon />
      </IconButton>
    </div>
  );
}

async function takePicture(viewer: Viewer): Promise<void> {
  const name = view.peek()?.robot.name ?? "tool0";
  save(await viewer.picture(), `${name}.png`);
}

/** The whole page, so that the controls stay within reach. */
function FullScreen() {
  const [isFull, setFull] = useState(document.fullscreenElement !== null);
  useEffect(() => {
    const update = () => {
      setFull(document.fullscreenElement !== null);
    };
    document.addEventListener("fullscreenchange", update);
    return () => {
      document.removeEventListener("fullscreenchange", update);
    };
  }, []);
  if (!document.fullscreenEnabled) return null;
  return (
    <IconButton
      label={t(isFull ? "layout.leaveFullScreen" : "layout.fullScreen")}
      aria-pressed={isFull}
      data-testid="full-screen"
      onClick={() => {
        if (isFull) leaveFullScreen();
        else void document.documentElement.requestFullscreen();
      }}
    >
      <FullScreenIcon />
    </IconButton>
  );
}
