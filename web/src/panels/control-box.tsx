/** The control box of an arm: power, safety, program, speed slider, pins and registers. */
import { useRef, useLayoutEffect, useState } from "preact/hooks";
import { sendRequest } from "../connection";
import { IDLE, isPowered, POWER_OFF, shownBox } from "../control-box";
import type { ControlBox } from "../control-box";
import { mayMove } from "../driving";
import { t } from "../i18n";
import { robots } from "../robots";
import { offers, unlessOffered, whyMissing } from "../store";
import { Badge } from "../ui/badge";
import type { Tone } from "../ui/badge";
import { Button } from "../ui/button";
import { NumberField } from "../ui/number-field";
import { share, Slider } from "../ui/slider";
import { AnalogPins, DigitalPins } from "./pins";

const PROGRAM_TONES: Record<ControlBox["program"], Tone> = {
  PLAYING: "ok",
  PAUSED: "warning",
  STOPPED: "neutral",
};

function robotTone(box: ControlBox): Tone {
  if (isPowered(box)) return box.robot_mode === 7 ? "ok" : "accent";
  return box.robot_mode === IDLE ? "warning" : "neutral";
}

function canPlay(box: ControlBox): boolean {
  return isPowered(box) && box.safety_mode <= 2;
}

/** Green while the arm may move, red while something stops it. */
function safetyTone({ safety_mode }: ControlBox): Tone {
  if (safety_mode === 1) return "ok";
  return safety_mode === 2 ? "warning" : "danger";
}

function ProgramBadge({ state, ...rest }: { state: string; "data-testid"?: string }) {
  const known = state === "PLAYING" || state === "PAUSED" || state === "STOPPED";
  return (
    <Badge tone={known ? PROGRAM_TONES[state] : "accent"} {...rest}>
      {known ? t(`box.program.${state}`) : state}
    </Badge>
  );
}

export function ControlBoxPanel() {
  const box = shownBox.value;
  if (box === null) return <p class="placeholder">{t("box.none")}</p>;
  return (
    <>
      <Modes box={box} />
      {box.ur !== null && <UrPrograms ur={box.ur} />}
      <DigitalPins box={box} kind="inputs" />
      <DigitalPins box={box} kind="outputs" />
      <AnalogPins box={box} />
    </>
  );
}

function Modes({ box }: { box: ControlBox }) {
  const { arm, program, robot_mode, safety_mode, taken_by } = box;
  const disabled = !mayMove.value;
  return (
    <section class="group" aria-labelledby="box-title">
      <header>
        <h2 id="box-title">
          {t("box.title")} {robots.value.length > 0 && <code class="muted">{arm}</code>}
        </h2>
      </header>
      <dl class="modes">
        <div>
          <dt>{t("box.arm")}</dt>
          <dd>
            <Badge tone={robotTone(box)} data-testid="robot-mode">
              {t(`box.robot.${robot_mode}`)}
            </Badge>
          </dd>
        </div>
        <div>
          <dt>{t("box.safety")}</dt>
          <dd>
            <Badge tone={safetyTone(box)} data-testid="safety-mode">
              {t(`box.safety.${safety_mode}`)}
            </Badge>
          </dd>
        </div>
        <div>
          <dt>{t("box.program")}</dt>
          <dd>
            {taken_by !== "" && <code class="muted">{taken_by}</code>}
            <ProgramBadge state={program} data-testid="program-state" />
          </dd>
        </div>
      </dl>
      <div class="row wrap">
        <Button
          disabled={disabled || robot_mode !== POWER_OFF}
          data-testid="power-on"
          onClick={() => void sendRequest("power_on", { arm })}
          {...unlessOffered("power_on")}
        >
          {t("box.powerOn")}
        </Button>
        <Button
          disabled={disabled || isPowered(box)}
          data-testid="release-brakes"
          onClick={() => void sendRequest("release_brakes", { arm })}
          {...unlessOffered("release_brakes")}
        >
          {t("box.releaseBrakes")}
        </Button>
        <Button
          disabled={robot_mode === POWER_OFF}
          data-testid="power-off"
          onClick={() => void sendRequest("power_off", { arm })}
          {...unlessOffered("power_off")}
        >
          {t("box.powerOff")}
        </Button>
      </div>
      <div class="row wrap">
        <Button
          disabled={disabled || program === "PLAYING" || !canPlay(box)}
          data-testid="program-play"
          onClick={() => void sendRequest("play_program", { arm })}
          {...unlessOffered("play_program")}
        >
          {t("box.play")}
        </Button>
        <Button
          disabled={program !== "PLAYING"}
          data-testid="program-pause"
          onClick={() => void sendRequest("pause_program", { arm })}
          {...unlessOffered("pause_program")}
        >
          {t("box.pause")}
        </Button>
        <Button
          disabled={program === "STOPPED"}
          data-testid="program-stop"
          onClick={() => void sendRequest("stop_program", { arm })}
          {...unlessOffered("stop_program")}
        >
          {t("box.stop")}
        </Button>
      </div>
      <SpeedSlider box={box} />
    </section>
  );
}

/** The speed slider; its marker is the factor that motions follow now. */
function SpeedSlider({ box }: { box: ControlBox }) {
  const [dragged, setDragged] = useState<number | null>(null);
  const marker = useRef<HTMLDivElement | null>(null);
  useLayoutEffect(() => {
    const at = String(share(box.speed_scaling, 0.01, 1));
    marker.current?.style.setProperty("--actual-at", at);
  });
  const percent = dragged ?? box.speed_slider * 100;
  const change = (value: number) => {
    setDragged(null);
    const fraction = Math.round(value) / 100;
    void sendRequest("set_speed_slider", { arm: box.arm, fraction });
  };
  const common = {
    min: 1,
    max: 100,
    step: 1,
    disabled: !mayMove.value || !offers("set_speed_slider"),
  };
  return (
    <div class="row labelled" title={whyMissing("set_speed_slider")}>
      <span class="caption">{t("box.speed")}</span>
      <Slider
        {...common}
        label={t("box.speedLong")}
        valueText={`${percent.toFixed(0)} %`}
        value={percent}
        root={marker}
        data-testid="box-speed"
        onInput={setDragged}
        onChange={change}
      />
      <NumberField
        {...common}
        label={t("box.speedLong")}
        unit="%"
        digits={0}
        value={percent}
        data-testid="box-speed-field"
        onCommit={change}
      />
    </div>
  );
}

function UrPrograms({ ur }: { ur: NonNullable<ControlBox["ur"]> }) {
  const registers = Object.entries(ur.registers ?? {});
  return (
    <section class="group" aria-labelledby="ur-title">
      <header>
        <h2 id="ur-title">{t("box.ur")}</h2>
        <span class="hint">{t("box.clients", { count: ur.clients ?? 0 })}</span>
      </header>
      <dl class="modes">
        <div>
          <dt>{t("box.program")}</dt>
          <dd data-testid="ur-program">
            {ur.program !== "" && <code class="muted">{ur.program}</code>}
            <ProgramBadge state={ur.program_state ?? ""} />
          </dd>
        </div>
      </dl>
      {ur.popup !== null && (
        <p class="popup" role="status" data-testid="ur-popup">
          {ur.popup}
        </p>
      )}
      <h3 class="subtitle">{t("box.registers")}</h3>
      {registers.length === 0 ? (
        <p class="hint">{t("box.noRegisters")}</p>
      ) : (
        <dl class="registers" data-testid="registers">
          {registers.map(([name, value]) => (
            <div key={name}>
              <dt>
                <code>{name}</code>
              </dt>
              <dd>{typeof value === "number" ? shown(value) : String(value)}</dd>
            </div>
          ))}
        </dl>
      )}
    </section>
  );
}

/** Return a number with at most six digits after the point. */
function shown(value: number): string {
  return String(Number(value.toFixed(6)));
}
