/** The canvas of one viewer, and its connection to the page. */
import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { need } from "../forces";
import { frames, shown } from "../frames";
import { guided } from "../guiding";
import { t } from "../i18n";
import { moving } from "../moving";
import type { ViewInfo } from "../protocol";
import { model } from "../model";
import { overlays } from "../overlays";
import { placing } from "../placing";
import { shownPath, shownPosture } from "../planning/way-around";
import { selected } from "../robots";
import { selection } from "../selection";
import { keyName } from "../shortcuts";
import {
  hoveredLink,
  showCollision,
  showGhost,
  shownFrames,
  shownScene,
  status,
} from "../store";
import { shownTheme, token } from "../ui/theme";
import { plannedPath } from "./path";
import { editByKey } from "./edit-keys";
import { plannedPose } from "./planned-pose";
import { showGizmo, target, watchTarget } from "../tool-target";
import { arm, framePose, toolFrame, toolPose } from "../tool";
import { watchPointer } from "./pointer";
import type { Quality } from "./quality";
import type { Colours } from "./stage";
import { Viewer } from "./viewer";
import type { View } from "./framing";

interface CanvasProps {
  view: ViewInfo;
  urdf: string;
  quality: Quality;
  onReady: (viewer: Viewer | null) => void;
  onProblem: (text: string | null) => void;
  onLost: () => void;
}

/** Keys of the view, besides the arrows, plus and minus. */
const VIEW_KEYS: Partial<Record<string, View>> = {
  1: "iso",
  2: "front",
  3: "left",
  4: "right",
  5: "top",
  6: "tool",
};

function coloursOf(theme: "light" | "dark"): Colours {
  return {
    grid: token("--scene-grid"),
    ghost: token("--scene-ghost"),
    highlight: token("--scene-highlight"),
    collision: token("--actual"),
    force: token("--scene-force"),
    contact: token("--scene-contact"),
    x: token("--axis-x"),
    y: token("--axis-y"),
    z: token("--axis-z"),
    dark: theme === "dark",
  };
}

function onKey(viewer: Viewer, event: KeyboardEvent): void {
  if (event.altKey) return;
  if (editByKey(keyName(event))) {
    event.preventDefault();
    return;
  }
  if (event.ctrlKey || event.metaKey) return;
  const view = VIEW_KEYS[event.key];
  if (view) viewer.look(view);
  else if (event.key === "f") viewer.fit();
  else if (!viewer.key(event.key)) return;
  event.preventDefault();
}

/** Keep the gizmo at the target, or at the tool without one; the result ends that. */
function followTool(viewer: Viewer): () => void {
  const place = () => {
    const isShown = showGizmo.value && arm.value !== null && !shown.isPast.value;
    const pose = target.value ?? toolPose();
    const axes = toolFrame.value === "tool" ? pose : framePose(toolFrame.value);
    viewer.gizmo.show(isShown ? pose : null, axes.R);
  };
  const ends = [effect(place), frames.listen(place)];
  return () => {
    for (const end of ends) end();
  };
}

/** Update the viewer when the store changes; the result ends that. */
function follow(
  viewer: Viewer,
  report: (failures: readonly string[]) => void,
): () => void {
  const ends = [
    effect(() => {
      if (shownScene.value) void viewer.surround(shownScene.value).then(report);
    }),
    effect(() => {
      viewer.paint(coloursOf(shownTheme.value));
    }),
    effect(() => {
      // who guides the arm sends it nowhere
      const isShown = showGhost.value && !shown.isPast.value && guided.value === null;
      const commanded = isShown ? (status.value?.targets ?? {}) : undefined;
      viewer.aim(shownPosture.value ?? plannedPose.value ?? commanded);
    }),
    effect(() => {
      viewer.offerMove(moving.value);
    }),
    effect(() => {
      viewer.select(selected.value);
    }),
    watchTarget(),
    followTool(viewer),
    effect(() => {
      viewer.choose(selection.value);
    }),
    effect(() => {
      viewer.showOverlays({
        contacts: overlays.contacts.value,
        wrench: overlays.wrench.value,
        inertia: overlays.inertia.value,
        trace: overlays.trace.value,
      });
    }),
    effect(() => need({ contacts: overlays.contacts.value })),
    effect(() => need({ wrenches: overlays.wrench.value })),
    effect(() => {
      viewer.showPath(shownPath.value ?? plannedPath.value);
    }),
    effect(() => {
      viewer.offerPlace(placing.value);
    }),
    effect(() => {
      viewer.showCollision(showCollision.value);
    }),
    effect(() => {
      viewer.highlight(hoveredLink.value);
      // a link without a shape is seen by its frame
      const hovered = hoveredLink.value;
      const bare = hovered !== null && !viewer.hasShape(hovered);
      viewer.showFrames(bare ? [...shownFrames.value, hovered] : shownFrames.value);
    }),
  ];
  return () => {
    for (const end of ends) end();
  };
}

/** Start a viewer in `host`; call the result to end it. */
function start(host: HTMLDivElement, props: CanvasProps): () => void {
  const canvas = document.createElement("canvas");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", t("scene.canvas"));
  const viewer = new Viewer(
    canvas,
    props.view,
    props.urdf,
    model.peek(),
    props.quality,
  );
  host.append(canvas, viewer.labels);
  const ends: (() => void)[] = [];

  const size = new ResizeObserver(() => {
    const { clientWidth, clientHeight } = host;
    if (clientWidth > 0 && clientHeight > 0) viewer.resize(clientWidth, clientHeight);
  });
  size.observe(host);
  canvas.addEventListener("webglcontextlost", props.onLost);
  canvas.addEventListener("keydown", (event) => {
    onKey(viewer, event);
  });
  for (const { frame, arrival } of shown.last) viewer.push(frame, arrival);
  ends.push(
    shown.listen((frame) => {
      viewer.push(frame, performance.now());
    }),
    watchPointer(host, canvas, viewer),
  );
  const counter = setInterval(() => {
    host.dataset.frames = String(viewer.drawn);
    if (showGizmo.peek()) host.dataset.gizmo = viewer.arrowAt.join(" ");
    host.dataset.eye = viewer.eyeHeight.toFixed(3);
  }, 500);

  let over = false;
  const report = (failures: readonly string[]) => {
    if (over) return;
    const reason = failures.join("; ");
    props.onProblem(reason ? t("scene.meshesFailed", { reason }) : null);
  };
  viewer.load(shownScene.peek()).then(
    (failures) => {
      if (over) return;
      ends.push(follow(viewer, report));
      host.dataset.ready = "true";
      props.onReady(viewer);
      report(failures);
    },
    (error: unknown) => {
      const reason = error instanceof Error ? error.message : String(error);
      if (!over) props.onProblem(t("scene.failed", { reason }));
    },
  );
  return () => {
    over = true;
    clearInterval(counter);
    size.disconnect();
    for (const end of ends) end();
    props.onReady(null);
    canvas.removeEventListener("webglcontextlost", props.onLost);
    viewer.dispose();
    host.replaceChildren();
    delete host.dataset.ready;
  };
}

export function Canvas(props: CanvasProps) {
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!host.current) return undefined;
    try {
      return start(host.current, props);
    } catch (error) {
      const reason = error instanceof Error ? error.message : String(error);
      props.onProblem(t("scene.failed", { reason }));
      return undefined;
    }
    // a change of the robot or of the quality creates a new Canvas
  }, []);
  return (
    <div
      class="scene-host"
      ref={host}
      data-testid="scene"
      data-quality={props.quality}
      data-placing={placing.value !== null}
    />
  );
}
