/** The canvas of one viewer, and its connection to the page. */
import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { frames } from "../frames";
import { t } from "../i18n";
import { moving } from "../moving";
import type { ViewInfo } from "../protocol";
import { selected } from "../robots";
import {
  hoveredLink,
  scene,
  showCollision,
  showGhost,
  shownFrames,
  status,
} from "../store";
import { shownTheme, token } from "../ui/theme";
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
    x: token("--axis-x"),
    y: token("--axis-y"),
    z: token("--axis-z"),
    dark: theme === "dark",
  };
}

function onKey(viewer: Viewer, event: KeyboardEvent): void {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const view = VIEW_KEYS[event.key];
  if (view) viewer.look(view);
  else if (event.key === "f") viewer.fit();
  else if (!viewer.key(event.key)) return;
  event.preventDefault();
}

/** Update the viewer when the store changes; the result ends that. */
function follow(
  viewer: Viewer,
  report: (failures: readonly string[]) => void,
): () => void {
  const ends = [
    effect(() => {
      if (scene.value) void viewer.surround(scene.value).then(report);
    }),
    effect(() => {
      viewer.paint(coloursOf(shownTheme.value));
    }),
    effect(() => {
      viewer.aim(showGhost.value ? (status.value?.targets ?? {}) : undefined);
    }),
    effect(() => {
      viewer.offerMove(moving.value?.target ?? null);
    }),
    effect(() => {
      viewer.select(selected.value);
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
  const viewer = new Viewer(canvas, props.view, props.urdf, props.quality);
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
  for (const { frame, arrival } of frames.last) viewer.push(frame, arrival);
  ends.push(
    frames.listen((frame) => {
      viewer.push(frame, performance.now());
    }),
    watchPointer(host, canvas, viewer),
  );
  const counter = setInterval(() => {
    host.dataset.frames = String(viewer.drawn);
  }, 500);

  let over = false;
  const report = (failures: readonly string[]) => {
    if (over) return;
    const reason = failures.join("; ");
    props.onProblem(reason ? t("scene.meshesFailed", { reason }) : null);
  };
  viewer.load(scene.peek()).then(
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
    />
  );
}
