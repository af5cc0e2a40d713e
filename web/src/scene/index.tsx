/** The 3D view.  Preact draws the frame and the buttons; the picture is the viewer's. */
import { computed, useSignal } from "@preact/signals";
import { useCallback, useEffect } from "preact/hooks";
import { connection } from "../connection";
import { t } from "../i18n";
import { model, modelFailure, urdfText } from "../model";
import { connectionState, view, status } from "../store";
import { Actions } from "./actions";
import { Canvas } from "./canvas";
import { PlacingHint, SelectionCard } from "./card";
import { GuideBar } from "./guide-bar";
import { GizmoHint } from "./gizmo-hint";
import { PlanCard } from "./plan-card";
import { quality } from "./quality";
import "./scene.css";
import { Toolbar } from "./toolbar";
import type { Viewer } from "./viewer";

function failureText(): string | null {
  const reason = modelFailure.value;
  return reason === null ? null : t("scene.failed", { reason });
}

/** What is shown; the key changes with it. */
const source = computed(() => {
  const info = view.peek();
  // the model is read again for each view; only then do both belong together
  if (!model.value || !info) return null;
  const urdf = urdfText.peek();
  return { view: info, urdf, key: JSON.stringify([info.robot, urdf]) };
});

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

  const shown = source.value;
  const chosen = quality.value;
  // the banner reports if there will be none
  const isLoading =
    viewer.value === null && !["refused", "outdated"].includes(connectionState.value);
  const message =
    chosen === null
      ? t("scene.noWebgl")
      : (problem.value ?? failureText() ?? (isLoading ? t("scene.loading") : null));

  const isSettled = chosen === null || viewer.value !== null || problem.value !== null;
  useEffect(() => {
    // to each server, also one that a page finds again
    if (isSettled && view.value !== null) void connection.request("view_shown");
  }, [isSettled, view.value]);

  return (
    <div class="scene-view" data-stopped={status.value?.stopped ?? false}>
      {shown && chosen && (
        <Canvas
          // another robot, another quality or a lost context: start again
          key={`${generation.value} ${chosen} ${shown.key}`}
          view={shown.view}
          urdf={shown.urdf}
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
      {viewer.value && <GuideBar />}
      {viewer.value && <Actions viewer={viewer.value} />}
      {viewer.value && <SelectionCard />}
      {viewer.value && <PlacingHint />}
      {viewer.value && <GizmoHint />}
      <PlanCard />
      {message !== null && (
        <p class="scene-message" role="status">
          {message}
        </p>
      )}
    </div>
  );
}
