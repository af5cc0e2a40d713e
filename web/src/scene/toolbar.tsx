/** Buttons over the picture: views, and what is shown. */
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { CameraToggles } from "../cameras/toggles";
import type { Key } from "../i18n";
import { t } from "../i18n";
import { type Overlay, overlays } from "../overlays";
import { selected } from "../robots";
import { showCollision, showGhost, shownFrames, status } from "../store";
import { IconButton } from "../ui/button";
import { EyeIcon } from "../ui/icons";
import { SignalToggle, Toggle } from "../ui/toggle";
import { type View, VIEWS } from "./framing";
import { FitIcon, VIEW_ICONS } from "./icons";
import { chooseQuality, quality } from "./quality";
import type { Viewer } from "./viewer";

const VIEW_NAMES: Record<View, Key> = {
  iso: "scene.view.iso",
  front: "scene.view.front",
  left: "scene.view.left",
  right: "scene.view.right",
  top: "scene.view.top",
  tool: "scene.view.tool",
};

const SHOWN: readonly (readonly [Overlay, Key])[] = [
  ["contacts", "scene.contacts"],
  ["wrench", "scene.wrench"],
  ["inertia", "scene.inertia"],
  ["trace", "scene.trace"],
];

function toggleFrame(name: string, shown: boolean): void {
  const next = new Set(shownFrames.value);
  if (shown) next.add(name);
  else next.delete(name);
  shownFrames.value = next;
}

function Options({ viewer }: { viewer: Viewer }) {
  const names = new Set([...viewer.usualFrames(selected.value), ...shownFrames.value]);
  return (
    <div class="scene-options" role="group" aria-label={t("scene.options")}>
      <p class="scene-heading">{t("scene.frames")}</p>
      {[...names].map((name) => (
        <Toggle
          key={name}
          label={name}
          checked={shownFrames.value.has(name)}
          data-testid={`scene-frame-${name}`}
          onChange={(shown) => {
            toggleFrame(name, shown);
          }}
        />
      ))}
      <CameraToggles />
      <p class="scene-heading">{t("scene.show")}</p>
      {status.value && (
        <SignalToggle
          label={t("scene.ghost")}
          of={showGhost}
          data-testid="scene-ghost"
        />
      )}
      <SignalToggle
        label={t("scene.collision")}
        of={showCollision}
        data-testid="scene-collision"
      />
      {SHOWN.map(([name, key]) => (
        <SignalToggle
          key={name}
          label={t(key)}
          of={overlays[name]}
          data-testid={`scene-show-${name}`}
        />
      ))}
      <Toggle
        label={t("scene.simple")}
        checked={quality.value === "low"}
        data-testid="scene-simple"
        onChange={(simple) => {
          chooseQuality(simple ? "low" : "high");
        }}
      />
    </div>
  );
}

export function Toolbar({ viewer }: { viewer: Viewer }) {
  const open = useSignal(false);
  const menu = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const close = (event: PointerEvent) => {
      if (!menu.current?.contains(event.target as Node)) open.value = false;
    };
    const closeOnEscape = (event: KeyboardEvent) => {
      if (event.key === "Escape") open.value = false;
    };
    document.addEventListener("pointerdown", close);
    document.addEventListener("keydown", closeOnEscape);
    return () => {
      document.removeEventListener("keydown", closeOnEscape);
      document.removeEventListener("pointerdown", close);
    };
  }, []);
  return (
    <>
      <div class="scene-bar views" role="toolbar" aria-label={t("scene.views")}>
        {VIEWS.map((view) => {
          const Icon = VIEW_ICONS[view];
          return (
            <IconButton
              key={view}
              label={t(VIEW_NAMES[view])}
              data-testid={`scene-view-${view}`}
              onClick={() => {
                viewer.look(view);
              }}
            >
              <Icon />
            </IconButton>
          );
        })}
        <IconButton
          label={t("scene.view.fit")}
          data-testid="scene-view-fit"
          onClick={() => {
            viewer.fit();
          }}
        >
          <FitIcon />
        </IconButton>
      </div>
      <div class="scene-bar options" ref={menu}>
        <IconButton
          label={t("scene.options")}
          aria-expanded={open.value}
          data-testid="scene-options"
          onClick={() => {
            open.value = !open.value;
          }}
        >
          <EyeIcon />
        </IconButton>
        {open.value && <Options viewer={viewer} />}
      </div>
    </>
  );
}
