/** The 3D view.  Preact draws the frame and the buttons; the picture is the viewer's. */
import { useSignal } from "@preact/signals";
import { useCallback } from "preact/hooks";
import { t } from "../i18n";
import { hello, status } from "../store";
import { Canvas } from "./canvas";
import { quality } from "./quality";
import "./scene.css";
import { Toolbar } from "./toolbar";
import type { Viewer } from "./viewer";

export default function SceneView() {
  const viewer = useSignal<Viewer | null>(null);
  const problem = useSignal<string | null>(null);
  const generation = useSignal(0);

  const onLost = useCallback(() => {
    // a little later: a browser that has just lost its GPU gives no new context yet
    setTimeout(() => {
      generation.value += 1;
    }, 500);
  }, []);

  const greeting = hello.value;
  const chosen = quality.value;
  const message =
    chosen === null
      ? t("scene.noWebgl")
      : (problem.value ?? (viewer.value ? null : t("scene.loading")));

  return (
    <div class="scene-view" data-stopped={status.value?.stopped ?? false}>
      {greeting && chosen && (
        <Canvas
          // another robot, another quality or a lost context: all anew
          key={`${greeting.robot.urdf} ${chosen} ${generation.value}`}
          hello={greeting}
          quality={chosen}
          onReady={(ready) => {
            viewer.value = ready;
          }}
          onProblem={(text) => {
            problem.value = text;
          }}
          onLost={onLost}
        />
      )}
      {viewer.value && <Toolbar viewer={viewer.value} />}
      {message !== null && (
        <p class="scene-message" role="status">
          {message}
        </p>
      )}
    </div>
  );
}
