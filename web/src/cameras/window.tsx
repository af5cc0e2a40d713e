/** A window over the scene with the live image of a camera. */
import { useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import type { CameraInfo } from "../protocol";
import { connectionState } from "../store";
import { IconButton } from "../ui/button";
import { Segmented } from "../ui/choice";
import { CloseIcon } from "../ui/icons";
import { Select } from "../ui/select";
import { colourAt } from "./depth";
import { keepPlace, moveByKey, startMove } from "./place";
import { Picture } from "./picture";
import { change, settingOf, WIDTHS } from "./state";
import { CameraStream } from "./stream";

interface WindowProps {
  camera: CameraInfo;
  /** Its place among the open windows. */
  index: number;
}

export function CameraWindow({ camera, index }: WindowProps) {
  const { name } = camera;
  const root = useRef<HTMLElement>(null);
  const { kind, width } = settingOf(name);
  useEffect(() => {
    if (root.current) return keepPlace(root.current, name, index);
    return undefined;
  }, [name]);
  const label = t("cameras.of", { name });
  return (
    <section
      class="camera-window"
      ref={root}
      aria-label={label}
      data-testid={`camera-${name}`}
    >
      <header
        tabIndex={0}
        role="group"
        aria-label={t("cameras.move", { name })}
        onPointerDown={(event) => {
          if (root.current) startMove(root.current, name, event);
        }}
        onKeyDown={(event) => {
          if (root.current) moveByKey(root.current, name, event);
        }}
      >
        <h2>{name}</h2>
        <Segmented
          label={t("cameras.kind")}
          value={kind}
          choices={[
            {
              value: "color",
              label: t("cameras.color"),
              testId: `camera-color-${name}`,
            },
            {
              value: "depth",
              label: t("cameras.depth"),
              testId: `camera-depth-${name}`,
            },
          ]}
          onChange={(next) => {
            change(name, { kind: next });
          }}
        />
        <Select
          label={t("cameras.width")}
          value={String(width)}
          options={WIDTHS.map((one) => ({
            value: String(one),
            label: `${String(one)} px`,
          }))}
          data-testid={`camera-width-${name}`}
          onChange={(next) => {
            change(name, { width: Number(next) });
          }}
        />
        <IconButton
          label={t("cameras.close", { name })}
          data-testid={`camera-close-${name}`}
          onClick={() => {
            change(name, { isOpen: false });
          }}
        >
          <CloseIcon />
        </IconButton>
      </header>
      {connectionState.value === "open" && (
        <CameraImage key={`${kind} ${String(width)}`} camera={camera} />
      )}
    </section>
  );
}

/** What is written below an image. */
interface Reading {
  readonly time: number;
  /** [1/s] */
  readonly rate: number;
  /** [m] */
  readonly range: readonly [number, number] | null;
}

function CameraImage({ camera }: { camera: CameraInfo }) {
  const { name } = camera;
  const { kind, width } = settingOf(name);
  const canvas = useRef<HTMLCanvasElement>(null);
  const picture = useRef<Picture | null>(null);
  const reading = useSignal<Reading | null>(null);
  const failure = useSignal<string | null>(null);
  const pointed = useSignal<readonly [number, number] | null>(null);

  useEffect(() => {
    const shown = canvas.current;
    if (shown === null) return undefined;
    const made = new Picture(shown, kind);
    picture.current = made;
    const stream = new CameraStream(
      { name, kind, width },
      {
        onImage: (image) => {
          failure.value = null;
          made.draw(image);
          shown.dataset.time = String(image.time);
          shown.dataset.count = String(Number(shown.dataset.count ?? 0) + 1);
          const range = made.range;
          reading.value = {
            time: image.time,
            rate: made.rate(),
            range: range && [range[0] / 1000, range[1] / 1000],
          };
        },
        onFailure: (reason) => {
          failure.value = reason;
        },
      },
    );
    return () => {
      stream.end();
    };
  }, [name, kind, width]);

  const depth =
    pointed.value &&
    reading.value &&
    (picture.current?.depthAt(...pointed.value) ?? null);
  return (
    <>
      <canvas
        ref={canvas}
        width={camera.width}
        height={camera.height}
        role="img"
        aria-label={t("cameras.of", { name })}
        data-testid={`camera-image-${name}`}
        onPointerMove={(event) => {
          pointed.value = placeIn(canvas, event);
        }}
        onPointerLeave={() => {
          pointed.value = null;
        }}
      />
      {failure.value !== null && <p class="camera-failure">{failure.value}</p>}
      <footer>
        {reading.value?.range && <DepthScale range={reading.value.range} />}
        {kind === "depth" && pointed.value !== null && (
          <output data-testid={`camera-depth-here-${name}`}>
            {depth === null ? "–" : `${depth.toFixed(3)} m`}
          </output>
        )}
        {reading.value && (
          <span class="camera-rate">
            {t("cameras.rate", {
              time: reading.value.time.toFixed(2),
              rate: reading.value.rate.toFixed(0),
            })}
          </span>
        )}
      </footer>
    </>
  );
}

function placeIn(
  canvas: RefObject<HTMLCanvasElement | null>,
  event: PointerEvent,
): readonly [number, number] | null {
  const box = canvas.current?.getBoundingClientRect();
  if (!box) return null;
  return [
    (event.clientX - box.left) / box.width,
    (event.clientY - box.top) / box.height,
  ];
}

function DepthScale({ range: [from, to] }: { range: readonly [number, number] }) {
  const bar = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    const stops = Array.from({ length: 9 }, (_one, i) => colourAt(i / 8));
    bar.current?.style.setProperty(
      "--scale",
      `linear-gradient(90deg, ${stops.join()})`,
    );
  }, []);
  return (
    <span class="camera-scale">
      ≤ {from.toFixed(2)} m
      <span class="camera-colours" ref={bar} />≥ {to.toFixed(2)} m
    </span>
  );
}
