/** Jogging: velocities of the tool while buttons, keys or sticks are held. */
import { effect, signal, untracked } from "@preact/signals";
import { connection, refusals } from "./connection";
import { isDriving } from "./driving";
import { frames } from "./frames";
import { apply, fromRotationVector, matrixOf, product, transposed } from "./kinematics";
import type { Pose } from "./kinematics";
import { report } from "./notices";
import { obstacleAhead, reportStop, stopsAtObstacles } from "./planning/check";
import { silence } from "./silence";
import { connectionState, offers, status } from "./store";
import { arm, framePose, toolFrame, toolPose } from "./tool";
import type { Vector } from "./urdf";

/** Along x, y, z and about them: shares of the speed, -1 to 1. */
export type Direction = readonly [number, number, number, number, number, number];

/** The range of the speed [m/s]. */
export const SLOWEST = 0.005;
export const FASTEST = 0.25;
/** Rotation that belongs to a speed [rad/m]: 1 rad/s at 250 mm/s. */
export const TURN = 4;
/** Steps: along [m] and about an axis [rad]. */
export const STEPS = [
  [0.0001, Math.PI / 1800],
  [0.001, Math.PI / 180],
  [0.01, Math.PI / 36],
  [0.05, Math.PI / 12],
] as const;

/** What the arm is moved by. */
const TAKEN_BY = "panel";
/** Between two commands [ms]. */
const INTERVAL_MS = 16;
/** Validity of a command [s of wall time]: so long the tool moves on if no other follows. */
const VALIDITY = 0.04;
/** The largest, for a page whose commands are late by itself. */
const MAX_VALIDITY = 0.12;
/** How long the tool takes to stop from any speed [s]. */
const STOPPING = 0.025;
/** How long it takes to full speed [s]. */
const STARTING = 0.1;
/** Of a step: it is slower than the speed if it would be shorter [s]. */
const SHORTEST_STEP = 0.1;
/** [m/s², rad/s²] */
const LEAST_ACCELERATION = 0.05;
/** Wall time without a command after which the server lets a press end [s]. */
const TIMEOUT = 1;
/** Standing still for so long, the arm is released to its controllers [ms]. */
const LINGER_MS = 1000;
const QUEUED_STEPS = 5;
/** How far the page looks ahead for obstacles [s]. */
const LOOKS_AHEAD = 0.5;
/** Between two looks [ms]. */
const LOOK_INTERVAL_MS = 150;
/** After so long without another answer the tool stops, within what was seen [ms]. */
const LOOK_VALID_MS = 300;

/** [m/s] */
export const jogSpeed = signal(0.05);
/** Which of `STEPS` a press moves by; null: as long as it is held. */
export const jogStep = signal<number | null>(null);
/** Whether this page has the arm: its controllers, and the sliders, are stopped. */
export const hasArm = signal(false);

const held = new Map<string, Direction>();
/** What was held when it was refused: it has to be released first. */
const blocked = new Set<string>();
let steps: Direction[] = [];
let phase: "free" | "taking" | "taken" = "free";
let takenArm: string | null = null;
/** Grows when the arm is taken or released. */
let generation = 0;
let pump: ReturnType<typeof setInterval> | undefined;
let linger: ReturnType<typeof setTimeout> | undefined;
/** Share of the speed that is reached. */
let level = 0;
/** Size of the last velocity, which sets how hard the tool brakes [m/s, rad/s]. */
let size = 0;
let sentAt = 0;
let gap = INTERVAL_MS;
/** When the step in progress ends [simulated s]. */
let stepEnds: number | null = null;
/** When the last look ahead that found nothing was begun, in this press or for this step. */
let freeAt = -Infinity;
let isLooking = false;
let lookedAt = -Infinity;
/** Grows with each press and step: the answer to an older look does not count. */
let motions = 0;

export function mayJog(): boolean {
  return (
    connectionState.value === "open" &&
    offers("speed_tool") &&
    isDriving.value &&
    silence.value === null &&
    status.value?.stopped === false &&
    arm.value !== null
  );
}

/**
 * Move as long as `source` holds this direction; zeros release it.
 *
 * What is held while nothing may move does not begin to move later by itself.
 */
export function hold(source: string, direction: Direction): void {
  if (!direction.some((share) => share !== 0)) {
    release(source);
  } else if (!mayJog()) {
    drop(source);
    blocked.add(source);
  } else if (!blocked.has(source)) {
    if (!held.has(source)) lookedAt = -Infinity; // another direction
    held.set(source, direction);
    begin();
  }
}

export function release(source: string): void {
  blocked.delete(source);
  drop(source);
}

function drop(source: string): void {
  if (held.delete(source) && held.size === 0 && steps.length === 0) rest();
}

/** Move by a step. */
export function step(direction: Direction): void {
  if (!mayJog() || steps.length >= QUEUED_STEPS) return;
  steps.push(direction);
  begin();
}

/** Stop at once; what is held has to be released before it moves again. */
export function halt(): void {
  const moved = held.size > 0 || steps.length > 0 || stepEnds !== null;
  for (const source of held.keys()) blocked.add(source);
  held.clear();
  steps = [];
  if (moved) rest();
}

/** Stop, and return the arm to its controllers; done when they have it. */
export async function letGo(): Promise<void> {
  halt();
  clearTimeout(linger);
  if (phase === "free") return;
  phase = "free";
  generation += 1;
  hasArm.value = false;
  await connection.request("return_arm", { arm: takenArm, by: TAKEN_BY });
}

function begin(): void {
  clearTimeout(linger);
  if (phase === "free") void take();
  else if (phase === "taken") start();
}

async function take(): Promise<void> {
  phase = "taking";
  takenArm = arm.value?.name ?? null;
  const ours = ++generation;
  const problem = await connection.request("take_arm", {
    arm: takenArm,
    by: TAKEN_BY,
  });
  if (ours !== generation) return; // it is released, or another one is taken
  if (problem !== null) {
    phase = "free";
    halt();
    report("error", problem.message);
    return;
  }
  phase = "taken";
  hasArm.value = true;
  if (!mayJog()) void letGo();
  else if (held.size > 0 || steps.length > 0) start();
  else rest();
}

function start(): void {
  if (pump !== undefined) return;
  lookAgain();
  sentAt = performance.now();
  pump = setInterval(tick, INTERVAL_MS);
  tick();
}

function rest(): void {
  clearInterval(pump);
  pump = undefined;
  stepEnds = null;
  if (phase !== "taken") return;
  send([0, 0, 0, 0, 0, 0], null);
  size = 0;
  clearTimeout(linger);
  linger = setTimeout(() => void letGo(), LINGER_MS);
}

function tick(): void {
  const now = performance.now();
  if (now - sentAt > 1000 * TIMEOUT) {
    void letGo(); // the page itself was away: it takes another press
    return;
  }
  gap = Math.max(now - sentAt, 0.95 * gap);
  if (held.size > 0) {
    const full = sum([...held.values()]).map(
      scaled(jogSpeed.value, jogSpeed.value * TURN),
    );
    const ahead = LOOKS_AHEAD * Math.max(1, status.value?.real_time_factor ?? 1);
    if (!mayGo(full.map((speed) => speed * ahead))) {
      level = 0;
      sentAt = now;
      return;
    }
    level = Math.min(1, level + (now - sentAt + 1) / 1000 / STARTING);
    send(
      full.map((speed) => speed * level),
      null,
    );
  } else {
    advanceSteps();
  }
  sentAt = now;
}

function scaled(linear: number, angular: number) {
  return (share: number, axis: number) => share * (axis < 3 ? linear : angular);
}

/** Return the sum of directions, no longer than one of them may be. */
function sum(directions: readonly Direction[]): number[] {
  const total = [0, 1, 2, 3, 4, 5].map((axis) =>
    directions.reduce((so, one) => so + (one[axis] ?? 0), 0),
  );
  const longest = Math.max(
    1,
    Math.hypot(...total.slice(0, 3)),
    Math.hypot(...total.slice(3)),
  );
  return total.map((share) => share / longest);
}

function advanceSteps(): void {
  const time = frames.latest?.time ?? 0;
  if (stepEnds !== null && time < stepEnds) return;
  stepEnds = null;
  const [direction] = steps;
  if (direction === undefined) {
    rest();
    return;
  }
  const [along, about] = STEPS[jogStep.value ?? 0] ?? STEPS[0];
  if (!mayGo(direction.map(scaled(along, about)))) return;
  steps.shift();
  lookAgain();
  const isTurn = direction.slice(3).some((share) => share !== 0);
  const way = isTurn ? about : along;
  const speed = Math.min(jogSpeed.value * (isTurn ? TURN : 1), way / SHORTEST_STEP);
  size = speed;
  send(direction.map(scaled(speed, speed)), way / speed);
  // the last frame is a little old, and the tool ramps down
  stepEnds = time + way / speed + 2 * STOPPING + 0.05;
}

/** Begin another motion from rest, with a look ahead before it. */
function lookAgain(): void {
  motions += 1;
  level = 0;
  freeAt = -Infinity;
  lookedAt = -Infinity;
}

/**
 * Return whether the tool may move, by `way` in the chosen frame [m, rad]: with the option,
 * after a look ahead that found nothing.  Others follow while it moves.
 */
function mayGo(way: readonly number[]): boolean {
  if (!stopsAtObstacles.peek()) return true;
  const now = performance.now();
  if (!isLooking && now - lookedAt >= LOOK_INTERVAL_MS) {
    lookedAt = now;
    void lookAhead(way);
  }
  return now - freeAt < LOOK_VALID_MS;
}

async function lookAhead(way: readonly number[]): Promise<void> {
  const [ours, begun] = [motions, performance.now()];
  isLooking = true;
  const there = { arm: takenArm, pose: matrixOf(toolAfter(way)) };
  const obstacle = await obstacleAhead(there);
  isLooking = false;
  if (pump === undefined || ours !== motions) return;
  if (obstacle === null) {
    // what is sent behind a look is read after it
    if (freeAt > -Infinity) gap = Math.max(gap, performance.now() - begun);
    freeAt = level > 0 ? begun : performance.now();
  } else {
    halt();
    reportStop(obstacle);
  }
}

/** Return the pose of the tool in the root after a way in the chosen frame [m, rad]. */
function toolAfter([
  x = 0,
  y = 0,
  z = 0,
  a = 0,
  b = 0,
  c = 0,
]: readonly number[]): Pose {
  const { p, R } = toolPose();
  const axes = framePose(toolFrame.value).R;
  const [dx, dy, dz] = apply(axes, [x, y, z]);
  const turn: Vector = apply(axes, [a, b, c]);
  return {
    p: [p[0] + dx, p[1] + dy, p[2] + dz],
    R: product(fromRotationVector(turn), R),
  };
}

/** Send a velocity in the chosen frame; it is valid for `duration` [simulated s]. */
function send(velocity: readonly number[], duration: number | null): void {
  const [vx = 0, vy = 0, vz = 0, wx = 0, wy = 0, wz = 0] = velocity;
  const R_base_root = transposed(framePose("base").R);
  const R = product(R_base_root, framePose(toolFrame.value).R);
  const fastest = Math.max(Math.hypot(vx, vy, vz), Math.hypot(wx, wy, wz));
  size = Math.max(size, fastest);
  const factor = status.value?.real_time_factor ?? 1;
  const validity = Math.min(MAX_VALIDITY, Math.max(VALIDITY, (1.5 * gap) / 1000));
  connection.post("speed_tool", {
    arm: takenArm,
    twist: [...apply(R, [vx, vy, vz]), ...apply(R, [wx, wy, wz])],
    acceleration: Math.max(LEAST_ACCELERATION, size / STOPPING),
    duration: duration ?? validity * Math.max(0.05, factor),
    timeout: duration === null ? TIMEOUT : null,
  });
}

/** Watch for what ends jogging; call the result to end the watch. */
export function watchJog(): () => void {
  const stop = () => {
    halt();
  };
  const hide = () => {
    if (document.hidden) halt();
  };
  const escape = (event: KeyboardEvent) => {
    if (event.key === "Escape") halt();
  };
  window.addEventListener("blur", stop);
  window.addEventListener("pagehide", stop);
  window.addEventListener("keydown", escape, { capture: true });
  document.addEventListener("visibilitychange", hide);
  const ends = [
    effect(() => {
      if (mayJog()) return;
      untracked(() => void letGo());
    }),
    effect(() => {
      if (refusals.value === 0) return;
      untracked(() => void letGo());
    }),
    effect(() => {
      const name = arm.value?.name ?? null;
      if (phase === "free" || name === takenArm) return;
      untracked(() => void letGo());
    }),
    () => {
      window.removeEventListener("blur", stop);
      window.removeEventListener("pagehide", stop);
      window.removeEventListener("keydown", escape, { capture: true });
      document.removeEventListener("visibilitychange", hide);
    },
  ];
  return () => {
    for (const end of ends) end();
  };
}
