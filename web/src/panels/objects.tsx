/** The objects around the robot: their poses, and how to move or remove them. */
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { useLive } from "../live";
import { aimAt, begin, moving, putThere, setKind } from "../moving";
import type { ViewObject } from "../protocol";
import { canRedo, canUndo, redo, removeObjects, targetOf, undo } from "../scene-edits";
import { frameName, shownTarget } from "../number-frame";
import { select, selection } from "../selection";
import { offers, scene, unlessOffered } from "../store";
import { Button, IconButton } from "../ui/button";
import { Segmented } from "../ui/choice";
import { RedoIcon, TrashIcon, UndoIcon } from "../ui/icons";
import { fixed } from "../ui/number-field";
import { angleUnit, unitOf } from "../units";
import { AddObject } from "./add-object";
import { FrameSwitch } from "./frame-switch";
import { PoseFields } from "./pose-fields";
import { UnitSwitch } from "./unit-switch";

export function ObjectsPanel() {
  const objects = scene.value?.objects ?? [];
  return (
    <>
      <section class="group" aria-labelledby="objects-title">
        <header>
          <h2 id="objects-title">{t("objects.title")}</h2>
          <span class="header-buttons">
            <IconButton
              label={t("edit.undo")}
              disabled={!canUndo.value}
              data-testid="objects-undo"
              onClick={() => void undo()}
            >
              <UndoIcon />
            </IconButton>
            <IconButton
              label={t("edit.redo")}
              disabled={!canRedo.value}
              data-testid="objects-redo"
              onClick={() => void redo()}
            >
              <RedoIcon />
            </IconButton>
          </span>
        </header>
        <div class="row">
          <FrameSwitch testId="objects-frame" />
          <UnitSwitch />
        </div>
        {objects.length === 0 && <p class="muted">{t("objects.none")}</p>}
        <ul class="objects">
          {grouped(objects).map(([whole, parts]) =>
            whole === null ? (
              parts.map((object) => <ObjectRow key={object.name} object={object} />)
            ) : (
              <Parts key={`${whole}.`} whole={whole} parts={parts} />
            ),
          )}
        </ul>
      </section>
      {offers("add_object") && <AddObject />}
    </>
  );
}

/**
 * Return the objects, those that stand still and are parts of one thing in one place: the
 * floor and walls of a bin are called `bin.floor`, `bin.left` and so on.
 */
export function grouped(
  objects: readonly ViewObject[],
): (readonly [whole: string | null, parts: readonly ViewObject[]])[] {
  const wholes = new Map<string, ViewObject[]>();
  for (const object of objects) {
    const dot = object.name.lastIndexOf(".");
    const isPart = object.mass === null && dot > 0;
    const key = isPart ? object.name.slice(0, dot + 1) : object.name;
    wholes.set(key, [...(wholes.get(key) ?? []), object]);
  }
  return [...wholes].map(([key, parts]) => [
    parts.length > 1 ? key.slice(0, -1) : null,
    parts,
  ]);
}

function Parts({ whole, parts }: { whole: string; parts: readonly ViewObject[] }) {
  return (
    <li>
      <details data-testid={`object-parts-${whole}`}>
        <summary>
          <code>{whole}</code>{" "}
          <span class="muted">{t("objects.parts", { count: parts.length })}</span>
        </summary>
        <Button
          data-testid={`object-remove-${whole}`}
          onClick={() => void removeObjects(parts)}
          {...unlessOffered("remove_object")}
        >
          <TrashIcon />
          {t("objects.remove", { name: whole })}
        </Button>
        <ul class="objects">
          {parts.map((object) => (
            <ObjectRow key={object.name} object={object} />
          ))}
        </ul>
      </details>
    </li>
  );
}

/** Return the description of an object: `Box 40 × 40 × 40 mm, 0.1 kg`. */
export function describeObject({ shape, mass }: ViewObject): string {
  const sizes = {
    box: shape.size ?? [],
    cylinder: [2 * (shape.radius ?? 0), shape.length ?? 0],
    sphere: [2 * (shape.radius ?? 0)],
    mesh: [],
    compound: [],
  }[shape.kind];
  const round = shape.kind === "cylinder" || shape.kind === "sphere" ? "⌀ " : "";
  const shown = sizes.map((size) => String(Number((size * 1000).toFixed(1))));
  const measures = shown.length > 0 ? ` ${round}${shown.join(" × ")} mm` : "";
  const weight =
    mass === null ? t("objects.still") : `${String(Number(mass.toPrecision(4)))} kg`;
  return `${t(`objects.${shape.kind}`)}${measures}, ${weight}`;
}

function ObjectRow({ object }: { object: ViewObject }) {
  const { name, rgba } = object;
  const move = moving.value?.name === name ? moving.value : null;
  const isSelected =
    selection.value?.kind === "object" && selection.value.name === name;
  const [red, green, blue] = rgba.map((part) => String(Math.round(255 * part)));
  useEffect(
    () => () => {
      if (moving.peek()?.name === name) begin(name, null);
    },
    [name],
  );
  return (
    <li data-testid={`object-row-${name}`}>
      <div class="object-head">
        <i
          class="swatch"
          style={{ background: `rgb(${String(red)} ${String(green)} ${String(blue)})` }}
        />
        <button
          type="button"
          class="object-name grow ellipsis"
          aria-pressed={isSelected}
          data-testid={`object-select-${name}`}
          onClick={() => {
            select(isSelected ? null : { kind: "object", name });
          }}
        >
          <code>{name}</code>
        </button>
        <Button
          aria-label={t("objects.moveLong", { name })}
          aria-expanded={move !== null}
          data-testid={`object-move-${name}`}
          onClick={() => {
            begin(name, (move === null && targetOf(name)) || null);
          }}
          {...unlessOffered("place_object")}
        >
          {t("objects.move")}
        </Button>
        <IconButton
          label={t("objects.remove", { name })}
          data-testid={`object-remove-${name}`}
          onClick={() => void removeObjects([object])}
          {...unlessOffered("remove_object")}
        >
          <TrashIcon />
        </IconButton>
      </div>
      <p class="muted">{describeObject(object)}</p>
      <LivePose name={name} testId={`object-pose-${name}`} />
      {move && (
        <div class="object-target">
          <p class="hint">{t("objects.moveHint")}</p>
          <Segmented
            label={t("edit.handles")}
            value={move.kind}
            choices={(["move", "rotate"] as const).map((kind) => ({
              value: kind,
              label: t(`edit.${kind}`),
              testId: `object-handles-${kind}`,
            }))}
            onChange={setKind}
          />
          <PoseFields value={move.target} testId="object-target" onChange={aimAt} />
          <Button
            kind="primary"
            data-testid={`object-put-${name}`}
            onClick={() => void putThere()}
          >
            {t("objects.put")}
          </Button>
          {move.problem && (
            <p class="refusal" role="alert" data-testid={`object-refusal-${name}`}>
              {move.problem.message}
            </p>
          )}
        </div>
      )}
    </li>
  );
}

/** The pose of an object, as it changes. */
export function LivePose({ name, testId }: { name: string; testId: string }) {
  const place = useRef<HTMLSpanElement | null>(null);
  const turn = useRef<HTMLSpanElement | null>(null);
  const unit = unitOf("revolute", angleUnit.value);
  useLive((frame) => {
    const now = targetOf(name, frame);
    if (!place.current || !turn.current || now === undefined) return;
    const target = shownTarget(now);
    const position = target.position.map((part) => fixed(part * 1000, 1)).join("  ");
    const angles = target.rpy
      .map((part) => fixed(part * unit.factor, unit.digits))
      .join("  ");
    place.current.textContent = `${position} mm`;
    turn.current.textContent = `${angles} ${unit.symbol}`;
  });
  return (
    <p class="object-pose">
      <span class="muted">{frameName()}</span>
      <span class="object-numbers" data-testid={testId}>
        <span ref={place} /> <span ref={turn} />
      </span>
    </p>
  );
}
