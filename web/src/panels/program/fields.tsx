/** What the fields of steps are made of: a caption and a control in a row. */
import type { ComponentChildren } from "preact";
import { t } from "../../i18n";
import { NumberField } from "../../ui/number-field";
import { type Option, Select } from "../../ui/select";
import { Toggle } from "../../ui/toggle";
import type { Unit } from "../../units";

export function Row({
  label,
  children,
}: {
  label: string;
  children: ComponentChildren;
}) {
  return (
    <div class="row step-row">
      <span class="caption grow">{label}</span>
      {children}
    </div>
  );
}

interface QuantityProps {
  label: string;
  /** SI, as are the limits. */
  value: number;
  unit: Unit;
  min: number;
  max: number;
  onCommit: (value: number) => void;
  "data-testid": string;
}

export function Quantity(props: QuantityProps) {
  const { label, value, unit, min, max, onCommit } = props;
  return (
    <Row label={label}>
      <NumberField
        label={label}
        unit={unit.symbol}
        value={value * unit.factor}
        digits={unit.digits}
        min={min * unit.factor}
        max={max * unit.factor}
        step={unit.step}
        data-testid={props["data-testid"]}
        onCommit={(shown) => {
          onCommit(shown / unit.factor);
        }}
      />
    </Row>
  );
}

interface OptionalProps extends Omit<QuantityProps, "value" | "onCommit"> {
  value: number | null;
  /** What it is when it is switched on. */
  initial: number;
  onCommit: (value: number | null) => void;
}

/** A quantity that may be left to the robot. */
export function OptionalQuantity(props: OptionalProps) {
  const { label, value, initial, onCommit } = props;
  return (
    <>
      <Toggle
        label={label}
        checked={value !== null}
        data-testid={`${props["data-testid"]}-on`}
        onChange={(isOn) => {
          onCommit(isOn ? initial : null);
        }}
      />
      {value !== null && <Quantity {...props} value={value} onCommit={onCommit} />}
    </>
  );
}

interface ChoiceProps {
  label: string;
  value: string;
  options: readonly Option[];
  onChange: (value: string) => void;
  "data-testid": string;
}

export function Choice(props: ChoiceProps) {
  return (
    <Row label={props.label}>
      <Select {...props} />
    </Row>
  );
}

/** High or low, of a digital pin. */
export function Level({
  level,
  onChange,
}: {
  level: boolean;
  onChange: (level: boolean) => void;
}) {
  return (
    <Choice
      label={t("program.level")}
      value={level ? "1" : "0"}
      options={[
        { value: "1", label: t("program.high") },
        { value: "0", label: t("program.low") },
      ]}
      data-testid="step-level"
      onChange={(value) => {
        onChange(value === "1");
      }}
    />
  );
}

const PINS = Array.from({ length: 18 }, (_, number) => number);

export function Pin(props: {
  label: string;
  pin: number;
  nameOf: (pin: number) => string;
  onChange: (pin: number) => void;
}) {
  return (
    <Choice
      label={props.label}
      value={String(props.pin)}
      options={PINS.map((number) => ({
        value: String(number),
        label: props.nameOf(number),
      }))}
      data-testid="step-pin"
      onChange={(value) => {
        props.onChange(Number(value));
      }}
    />
  );
}
