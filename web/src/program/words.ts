/** Steps in words, as the list shows them. */
import { t } from "../i18n";
import { fixed } from "../ui/number-field";
import { angleUnit, type Unit, unitOf } from "../units";
import { isLoop, type MoveStep, type Step } from "./steps";

/** The server's defaults, as `tool0.programs.model` has them. */
export const DEFAULTS = {
  move_joint: { speed: 1.05, acceleration: 1.4 },
  move_linear: { speed: 0.25, acceleration: 1.2 },
  until: { speed: 0.02, acceleration: 1.2 },
} as const;

/** Of speeds and accelerations of the tool. */
export const MM_PER_S: Unit = { symbol: "mm/s", factor: 1000, digits: 0, step: 10 };
export const MM_PER_S2: Unit = { symbol: "mm/s²", factor: 1000, digits: 0, step: 100 };
export const SECONDS: Unit = { symbol: "s", factor: 1, digits: 2, step: 0.1 };
export const NEWTONS: Unit = { symbol: "N", factor: 1, digits: 1, step: 1 };

/** Of speeds and accelerations of joints, in the unit of angles that the user chose. */
export function jointUnit(power: "/s" | "/s²"): Unit {
  const unit = unitOf("revolute", angleUnit.value);
  const isDegrees = unit.factor !== 1;
  return {
    ...unit,
    symbol: `${unit.symbol}${power}`,
    digits: isDegrees ? 0 : 2,
    step: isDegrees ? 5 : 0.05,
  };
}

export function quantity(value: number, { symbol, factor, digits }: Unit): string {
  return `${String(Number(fixed(value * factor, digits)))} ${symbol}`;
}

/** Return what kind of step it is. */
export function titleOf(step: Step): string {
  return t(`program.kind.${step.kind}`);
}

/** Return what it does, in a few words. */
export function detailOf(step: Step): string {
  switch (step.kind) {
    case "move_joint":
      return detailOfMove(step, jointUnit("/s"));
    case "move_linear":
      return detailOfMove(step, MM_PER_S);
    case "gripper":
      return gripText(step);
    case "wait":
      return waitText(step);
    case "until": {
      const { force = null, direction, frame = "root", distance } = step;
      return t(force === null ? "program.untilContact" : "program.untilForce", {
        direction: directionText(direction, frame),
        distance: quantity(distance, { ...MM_PER_S, symbol: "mm" }),
        force: force === null ? "" : quantity(force, NEWTONS),
      });
    }
    case "place_object":
      return step.name;
    case "set_output":
      return `${pinText(step.output)} = ${String(Number(step.level ?? true))}`;
    case "comment":
      return step.text;
    case "loop":
      return loopText(step);
  }
}

function detailOfMove(step: MoveStep, unit: Unit): string {
  const speed = quantity(step.speed ?? DEFAULTS[step.kind].speed, unit);
  const { blend = 0 } = step;
  const radius = quantity(blend, { ...MM_PER_S, symbol: "mm" });
  return [targetText(step), speed, ...(blend > 0 ? [`r ${radius}`] : [])].join(" · ");
}

function targetText({ label = "", named_pose: named, pose }: MoveStep): string {
  if (label !== "") return label;
  if (named != null) return named;
  return t(pose ? "program.toPose" : "program.toJoints");
}

function gripText({ opening, force = null }: GripLike): string {
  const width = openingText(opening);
  return force === null ? width : `${width} · ${quantity(force, NEWTONS)}`;
}
interface GripLike {
  opening: number | "open" | "closed";
  force?: number | null;
}

function openingText(opening: number | "open" | "closed"): string {
  if (typeof opening === "string")
    return t(opening === "open" ? "program.opened" : "program.closed");
  return quantity(opening, { symbol: "mm", factor: 1000, digits: 1, step: 1 });
}

function waitText({ duration = null, input = null, level = true }: WaitLike): string {
  const time = duration === null ? "" : quantity(duration, SECONDS);
  if (input === null) return time;
  const condition = `${inputText(input)} = ${String(Number(level))}`;
  return time === "" ? condition : `${condition} (≤ ${time})`;
}
interface WaitLike {
  duration?: number | null;
  input?: number | null;
  level?: boolean;
}

function loopText(step: Extract<Step, { kind: "loop" }>): string {
  if (!isLoop(step)) return "";
  const { times = null, while_input: input = null, level = true } = step;
  if (input !== null) {
    return t("program.while", {
      condition: `${inputText(input)} = ${String(Number(level))}`,
    });
  }
  return times === null ? t("program.forever") : t("program.times", { count: times });
}

/** Return the name of a digital pin, as UR's have it. */
function pin(number: number, letter: "I" | "O"): string {
  if (number < 8) return `D${letter}${String(number)}`;
  if (number < 16) return `C${letter}${String(number - 8)}`;
  return `T${letter}${String(number - 16)}`;
}
export const inputText = (number: number) => pin(number, "I");
export const pinText = (number: number) => pin(number, "O");

type Direction = readonly [number, number, number];

/** Return a direction along an axis as `-z`; else its numbers. */
export function directionText(direction: Direction, frame: "root" | "tool"): string {
  const along = direction.map((part) => part !== 0);
  const axis = "xyz"[along.indexOf(true)] ?? "?";
  const isAxis = along.filter(Boolean).length === 1;
  const sign = direction.some((part) => part < 0) ? "−" : "+";
  const text = isAxis ? `${sign}${axis}` : `(${direction.map(String).join(", ")})`;
  return frame === "tool" ? t("program.ofTool", { direction: text }) : text;
}
