/** Three numbers of a kind, as x, y and z. */
import type { Unit } from "../units";
import type { Vector } from "../urdf";
import { NumberField } from "./number-field";

const AXES = ["x", "y", "z"] as const;

interface VectorFieldProps {
  label: string;
  /** Of the components, for screen readers; x, y and z if left out. */
  axes?: readonly [string, string, string];
  unit: Unit;
  /** SI, as are the limits. */
  value: Vector;
  min: number;
  max: number;
  onCommit: (value: Vector) => void;
  "data-testid": string;
}

export function VectorField(props: VectorFieldProps) {
  const { unit, value, axes = AXES } = props;
  return (
    <div class="vector" role="group" aria-label={props.label}>
      <span class="caption">
        {props.label} <span class="muted">[{unit.symbol}]</span>
      </span>
      <div class="row">
        {axes.map((axis, index) => (
          <NumberField
            key={axis}
            label={`${props.label} ${axis}`}
            prefix={axis}
            unit={unit.symbol}
            showsUnit={false}
            digits={unit.digits}
            min={props.min * unit.factor}
            max={props.max * unit.factor}
            step={unit.step}
            value={(value[index] ?? 0) * unit.factor}
            data-testid={`${props["data-testid"]}-${String(index)}`}
            onCommit={(shown) => {
              const changed = value.map((old, at) =>
                at === index ? shown / unit.factor : old,
              );
              props.onCommit([changed[0] ?? 0, changed[1] ?? 0, changed[2] ?? 0]);
            }}
          />
        ))}
      </div>
    </div>
  );
}
