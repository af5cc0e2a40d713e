/** The pins of a control box: inputs can be set in place of wires, outputs are shown. */
import { sendRequest } from "../connection";
import { analogScale, PIN_GROUPS } from "../control-box";
import type { ControlBox, PinGroup } from "../control-box";
import { mayMove } from "../driving";
import { t } from "../i18n";
import type { AnalogPin } from "../protocol";
import { offers, unlessOffered, whyMissing } from "../store";
import { fixed, NumberField } from "../ui/number-field";

type Kind = "inputs" | "outputs";

export function DigitalPins({ box, kind }: { box: ControlBox; kind: Kind }) {
  const title = `box-digital-${kind}`;
  return (
    <section class="group" aria-labelledby={title}>
      <header>
        <h2 id={title}>{t(`box.digital.${kind}`)}</h2>
      </header>
      {PIN_GROUPS.map((group) => (
        <PinRow key={group.name} box={box} kind={kind} group={group} />
      ))}
      {kind === "inputs" && !mayMove.value && <p class="hint">{t("box.readOnly")}</p>}
    </section>
  );
}

interface PinRowProps {
  box: ControlBox;
  kind: Kind;
  group: PinGroup;
}

function PinRow({ box, kind, group }: PinRowProps) {
  const { name, first, count } = group;
  const levels = kind === "inputs" ? box.digital_inputs : box.digital_outputs;
  return (
    <div class="pins">
      <span class="caption">{t(`box.pins.${name}`)}</span>
      <ul aria-label={`${t(`box.digital.${kind}`)}, ${t(`box.pins.${name}`)}`}>
        {levels.slice(first, first + count).map((level, number) => {
          const pin = first + number;
          const label = t(`box.pin.${name}`, { number });
          const testId = `pin-${kind}-${String(pin)}`;
          return (
            <li key={pin}>
              {kind === "inputs" ? (
                <button
                  type="button"
                  class="pin"
                  role="switch"
                  aria-checked={level}
                  aria-label={label}
                  title={label}
                  disabled={!mayMove.value}
                  data-testid={testId}
                  onClick={() =>
                    void sendRequest("set_io", {
                      arm: box.arm,
                      digital_inputs: { [pin]: !level },
                    })
                  }
                  {...unlessOffered("set_io")}
                >
                  {number}
                </button>
              ) : (
                <span
                  class="pin"
                  role="img"
                  aria-label={`${label}: ${t(level ? "box.high" : "box.low")}`}
                  title={label}
                  data-level={level}
                  data-testid={testId}
                >
                  {number}
                </span>
              )}
            </li>
          );
        })}
      </ul>
    </div>
  );
}

export function AnalogPins({ box }: { box: ControlBox }) {
  return (
    <section class="group" aria-labelledby="box-analog">
      <header>
        <h2 id="box-analog">{t("box.analog")}</h2>
      </header>
      {box.analog_inputs.map((pin, number) => (
        <AnalogInput key={number} box={box} pin={pin} number={number} tool={false} />
      ))}
      {box.tool_analog_inputs.map((pin, number) => (
        <AnalogInput key={number} box={box} pin={pin} number={number} tool />
      ))}
      <dl class="modes">
        {box.analog_outputs.map((pin, number) => {
          const { unit, factor } = analogScale(pin);
          return (
            <div key={number}>
              <dt>{t("box.analogOutput", { number })}</dt>
              <dd data-testid={`analog-output-${String(number)}`}>
                {fixed((pin.value ?? 0) * factor, 2)} {unit}
              </dd>
            </div>
          );
        })}
        <div>
          <dt>{t("box.toolVoltage")}</dt>
          <dd data-testid="tool-voltage">{box.tool_voltage} V</dd>
        </div>
      </dl>
    </section>
  );
}

interface AnalogInputProps {
  box: ControlBox;
  pin: AnalogPin;
  number: number;
  /** Whether it is an input of the tool. */
  tool: boolean;
}

function AnalogInput({ box, pin, number, tool }: AnalogInputProps) {
  const { unit, factor, min, max } = analogScale(pin);
  const label = t(tool ? "box.toolInput" : "box.analogInput", { number });
  return (
    <div class="row" title={whyMissing("set_analog_input")}>
      <span class="grow">{label}</span>
      <NumberField
        label={label}
        unit={unit}
        digits={2}
        min={Math.min(min, (pin.value ?? 0) * factor)}
        max={max}
        step={0.1}
        value={(pin.value ?? 0) * factor}
        disabled={!mayMove.value || !offers("set_analog_input")}
        data-testid={`analog-input-${tool ? "tool-" : ""}${String(number)}`}
        onCommit={(value) =>
          void sendRequest("set_analog_input", {
            arm: box.arm,
            pin: number,
            value: value / factor,
            domain: pin.domain ?? 1,
            tool,
          })
        }
      />
    </div>
  );
}
