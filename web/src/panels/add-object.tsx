/** A new object: its shape, mass and pose. */
import { useState } from "preact/hooks";
import { t } from "../i18n";
import { type NewObject, placing, type SimpleShape, togglePlacing } from "../placing";
import type { ErrorInfo } from "../protocol";
import { addObject, freeName } from "../scene-edits";
import { Button } from "../ui/button";
import { Segmented } from "../ui/choice";
import { NumberField } from "../ui/number-field";
import { Toggle } from "../ui/toggle";
import { VectorField } from "../ui/vector-field";
import { MILLIMETRES } from "../units";
import type { Vector } from "../urdf";
import { PoseFields } from "./pose-fields";

type Kind = SimpleShape["kind"];
const KINDS: readonly Kind[] = ["box", "cylinder", "sphere"];
/** The range that the server accepts [m]. */
const LENGTH = { min: 0.001, max: 100 } as const;

export function AddObject() {
  const [kind, setKind] = useState<Kind>("box");
  const [name, setName] = useState("");
  const [size, setSize] = useState<Vector>([0.04, 0.04, 0.04]);
  const [radius, setRadius] = useState(0.03);
  const [length, setLength] = useState(0.1);
  const [target, setTarget] = useState({
    position: [0.5, 0, 0.1] as Vector,
    rpy: [0, 0, 0] as Vector,
  });
  const [isMovable, setMovable] = useState(true);
  const [mass, setMass] = useState(0.1);
  const [friction, setFriction] = useState(1);
  const [problem, setProblem] = useState<ErrorInfo | null>(null);
  const suggested = freeName(kind);

  const shape = (): SimpleShape => {
    if (kind === "box") return { kind, size: [...size] };
    return kind === "sphere" ? { kind, radius } : { kind, radius, length };
  };
  const described = (): NewObject => ({
    name: name.trim() || suggested,
    shape: shape(),
    mass: isMovable ? mass : null,
    friction,
  });
  const add = async () => {
    const refusal = await addObject({
      ...described(),
      xyz: [...target.position],
      rpy: [...target.rpy],
    });
    setProblem(refusal);
    if (refusal === null) setName("");
  };
  const measure = (
    label: "objects.radius" | "objects.length",
    value: number,
    onCommit: (value: number) => void,
  ) => (
    <div class="row labelled">
      <span class="caption grow">{t(label)}</span>
      <NumberField
        label={t(label)}
        unit="mm"
        digits={1}
        min={LENGTH.min * 1000}
        max={LENGTH.max * 1000}
        step={1}
        value={value * 1000}
        data-testid={`object-${label === "objects.radius" ? "radius" : "length"}`}
        onCommit={(shown) => {
          onCommit(shown / 1000);
        }}
      />
    </div>
  );

  return (
    <section class="group" aria-labelledby="add-object-title">
      <header>
        <h2 id="add-object-title">{t("objects.add")}</h2>
        <Segmented
          label={t("objects.kind")}
          value={kind}
          data-testid="object-kind"
          choices={KINDS.map((one) => ({
            value: one,
            label: t(`objects.${one}`),
            testId: `object-kind-${one}`,
          }))}
          onChange={setKind}
        />
      </header>
      <span class="field">
        <input
          type="text"
          maxLength={200}
          value={name}
          placeholder={`${t("objects.name")}: ${suggested}`}
          aria-label={t("objects.name")}
          data-testid="object-name"
          onInput={(event) => {
            setName(event.currentTarget.value);
          }}
        />
      </span>
      {kind === "box" && (
        <VectorField
          label={t("objects.size")}
          unit={MILLIMETRES}
          {...LENGTH}
          value={size}
          data-testid="object-size"
          onCommit={setSize}
        />
      )}
      {kind !== "box" && measure("objects.radius", radius, setRadius)}
      {kind === "cylinder" && measure("objects.length", length, setLength)}
      <PoseFields value={target} testId="object" onChange={setTarget} />
      <div class="row labelled">
        <span class="caption grow">{t("objects.friction")}</span>
        <NumberField
          label={t("objects.friction")}
          digits={2}
          min={0}
          max={100}
          step={0.1}
          value={friction}
          data-testid="object-friction"
          onCommit={setFriction}
        />
      </div>
      <div class="row labelled">
        <span class="grow">
          <Toggle
            label={t("objects.movable")}
            checked={isMovable}
            data-testid="object-movable"
            onChange={setMovable}
          />
        </span>
        <NumberField
          label={t("objects.mass")}
          unit="kg"
          digits={3}
          min={0.001}
          max={10_000}
          step={0.01}
          value={mass}
          disabled={!isMovable}
          data-testid="object-mass"
          onCommit={setMass}
        />
      </div>
      <div class="row wrap">
        <Button kind="primary" data-testid="object-add" onClick={() => void add()}>
          {t("objects.addIt")}
        </Button>
        <Button
          aria-pressed={placing.value !== null}
          data-testid="object-place"
          onClick={() => {
            togglePlacing(described());
          }}
        >
          {t("edit.place")}
        </Button>
      </div>
      {problem && (
        <p class="refusal" role="alert" data-testid="object-add-refusal">
          {problem.message}
        </p>
      )}
    </section>
  );
}
