/** Driving: whether this page may move the robot, the controller of the sliders, and the targets. */
import { batch, computed, effect, signal } from "@preact/signals";
import type { Signal } from "@preact/signals";
import { connection, refusals, unreached } from "./connection";
import { frames, shown } from "./frames";
import { obstacleAhead, reportStop, stopsAtObstacles } from "./planning/check";
import type { ControllerInfo, ErrorInfo, Status } from "./protocol";
import { silence } from "./silence";
import { chosenRobot, isOurController, selected } from "./robots";
import { connectionState, jointIndex, offers, status } from "./store";
import { arm } from "./tool";

/** Why driving ended by itself. */
export type EndReason = "stopped" | "reset" | "lost" | "silent" | "elsewhere" | "past";

/** Another page's target must differ for so long, since messages cross. */
const ELSEWHERE_AFTER_MS = 500;
/** After Stop the target is where the brakes bring it. */
const SETTLES_WITHIN_MS = 1500;
/** [rad | m] */
const SAME_TARGET = 2e-3;

/** Part of each joint's largest velocity. */
export const speedScale = signal(0.5);
/** Robot, or "" for a single one → the controller that the user chose. */
const chosenControllers = signal<ReadonlyMap<string, string>>(new Map());
/** Whether the user switched *Drive* on: a page opens read-only. */
export const isDriving = signal(false);
/** Whether controls that move the robot are enabled; without physics they always are. */
export const mayMove = computed(() => isDriving.value || offers("pose_joints"));
/** Joint → commanded position while driving; null while the sliders only follow. */
export const goals = signal<ReadonlyMap<string, Signal<number>> | null>(null);
export const endReason = signal<EndReason | null>(null);

/** Time for which the server may still follow earlier setpoints of this page. */
const REMEMBERED_MS = 5000;

/** Joint → the server's expected target; another client moves the robot if it differs. */
let expected: ReadonlyMap<string, number> = new Map();
/** Recent expected targets, and until when they are valid. */
let before: { targets: ReadonlyMap<string, number>; until: number }[] = [];
let differsSince: number | null = null;
let settlesUntil = -Infinity;
let lastTime = -Infinity;
let isLooking = false;
/** Grows when a slider is moved, with *Stop in front of obstacles*. */
let changes = 0;

export function canDrive(controller: ControllerInfo): boolean {
  return controller.is_running && controller.undrivable === null;
}

function robotKey(): string {
  return selected.value?.name ?? "";
}

/** Forget which controllers the user chose. */
export function forgetChoices(): void {
  chosenControllers.value = new Map();
}

/** Return the controller chosen for the selected robot, or its first that can be driven. */
export function controllerOf(now: Status | null): ControllerInfo | undefined {
  const all = (now?.controllers ?? []).filter(isOurController);
  const chosen = chosenControllers.value.get(robotKey());
  return (
    all.find((controller) => controller.name === chosen) ??
    all.find(canDrive) ??
    all.find((controller) => controller.joints.length > 0)
  );
}

/** Start driving; nothing moves until a control is used. */
export function enable(): void {
  if (status.value === null || status.value.stopped || silence.value !== null) return;
  isDriving.value = true;
  endReason.value = null;
  review(status.value, performance.now());
}

/** Make the page read-only again; the robot still completes its last command. */
export function disable(reason: EndReason | null = null): void {
  if (!isDriving.value) return;
  isDriving.value = false;
  endReason.value = reason;
  release();
  // What is on its way to a silent server would be carried out when it answers again.
  if (reason === "silent" && connection.mayBeOnItsWay()) void holdStill();
}

/** Drive another controller. */
export function choose(controller: string): void {
  retake(() => {
    remember(controller);
  });
}

/** Drive another robot. */
export function selectRobot(name: string): void {
  if (name === selected.value?.name) return;
  retake(() => {
    chosenRobot.value = name;
  });
}

/** Let go, change what is driven, and take that, before anything else reviews. */
function retake(change: () => void): void {
  batch(() => {
    release();
    change();
    review(status.value, performance.now());
  });
}

function remember(controller: string): void {
  if (chosenControllers.value.get(robotKey()) === controller) return;
  chosenControllers.value = new Map(chosenControllers.value).set(
    robotKey(),
    controller,
  );
}

/** Start the sliders at the present setpoints, so that nothing moves. */
function take(controller: ControllerInfo, now: Status): void {
  remember(controller.name);
  expect(now.targets);
  before = [];
  goals.value = new Map(
    controller.joints.map((joint) => [joint, signal(wantedNow(joint) ?? 0)]),
  );
}

/** Let the sliders follow the robot. */
function release(): void {
  connection.dropStreams();
  goals.value = null;
}

/** Set the target of a joint [rad | m]. */
export function drive(joint: string, position: number): void {
  const goal = goals.value?.get(joint);
  if (goal === undefined) return;
  goal.value = position;
  if (stopsAtObstacles.peek()) void sendIfFree();
  else sendGoals();
}

/** Send the newest targets if nothing is in the way there; otherwise take them back. */
async function sendIfFree(): Promise<void> {
  changes += 1;
  if (isLooking) return;
  isLooking = true;
  let seen = 0;
  while (seen !== changes) {
    seen = changes;
    const driven = goals.peek();
    const positions = Object.fromEntries(wanted());
    const there = { arm: arm.peek()?.name ?? null, positions };
    const obstacle = await obstacleAhead(there);
    if (driven === null || driven !== goals.peek()) continue;
    if (obstacle === null) {
      sendGoals(positions);
    } else if (seen === changes) {
      takeBack(driven);
      reportStop(obstacle);
    }
  }
  isLooking = false;
}

/** Set the sliders to where the robot was sent. */
function takeBack(driven: ReadonlyMap<string, Signal<number>>): void {
  for (const [joint, goal] of driven) goal.value = expected.get(joint) ?? goal.value;
}

/** Set the targets of several joints [rad | m]; return whether the sliders drive them all. */
export function driveTo(positions: Readonly<Record<string, number>>): boolean {
  const now = goals.value;
  if (!now || Object.keys(positions).some((joint) => !now.has(joint))) return false;
  batch(() => {
    for (const [joint, position] of Object.entries(positions)) {
      const goal = now.get(joint);
      if (goal) goal.value = position;
    }
  });
  sendGoals();
  return true;
}

/** Take the targets of a motion that this page just requested and that the server plans. */
export function followPlan(): void {
  settlesUntil = performance.now() + SETTLES_WITHIN_MS;
}

/** Take the positions of a pose that this page just sent the robot to. */
export function adopt(positions: Readonly<Record<string, number>>): void {
  for (const [joint, goal] of goals.value ?? []) {
    goal.value = positions[joint] ?? goal.value;
  }
  expect(Object.fromEntries(wanted()));
}

/** Stop the controller where it is. */
export function holdStill(): Promise<ErrorInfo | null> {
  const controller = controllerOf(status.value);
  if (!controller) return Promise.resolve(null);
  connection.dropStreams();
  settlesUntil = performance.now() + SETTLES_WITHIN_MS;
  return connection.request("command_trajectory", { controller: controller.name });
}

function sendGoals(positions = Object.fromEntries(wanted())): void {
  const controller = chosenControllers.value.get(robotKey());
  if (controller === undefined) return;
  connection.stream("steer_joints", { controller, positions, speed: speedScale.value });
  expect(positions);
}

function wanted(): (readonly [string, number])[] {
  return [...(goals.value ?? [])].map(([joint, goal]) => [joint, goal.peek()] as const);
}

function wantedNow(joint: string): number | undefined {
  const index = jointIndex.value.get(joint);
  const frame = frames.latest;
  if (index === undefined || frame === undefined) return undefined;
  return frame.desired[index] ?? frame.position[index];
}

function expect(targets: Readonly<Record<string, number>>): void {
  const now = performance.now();
  before = before.filter(({ until }) => now - until < REMEMBERED_MS);
  before.push({ targets: expected, until: now });
  expected = new Map(Object.entries(targets));
  settlesUntil = -Infinity;
  differsSince = null;
}

/** Return whether the robot moves to a target that this page did not send. */
function isElsewhere(now: Status, wallTimeMs: number): boolean {
  const late = before.filter(({ until }) => wallTimeMs - until < REMEMBERED_MS);
  return ![{ targets: expected }, ...late].some(({ targets }) =>
    isHeadingFor(targets, now),
  );
}

function isHeadingFor(mine: ReadonlyMap<string, number>, now: Status): boolean {
  return [...(goals.value?.keys() ?? [])].every((joint) => {
    const [target, wanted] = [now.targets[joint], mine.get(joint)];
    if (target === undefined || wanted === undefined) return true;
    return Math.abs(target - wanted) <= SAME_TARGET;
  });
}

/** Return whether the robot rests at its target: a motion has ended there, or was ended. */
function hasStopped(now: Status): boolean {
  return [...(goals.value?.keys() ?? [])].every((joint) => {
    const [target, desired] = [now.targets[joint], wantedNow(joint)];
    if (target === undefined || desired === undefined) return true;
    return Math.abs(target - desired) <= SAME_TARGET;
  });
}

/** Set the sliders to the robot's own target. */
function takeTargets({ targets }: Status): void {
  for (const [joint, goal] of goals.value ?? []) {
    goal.value = targets[joint] ?? goal.value;
  }
  before = [];
  expected = new Map(Object.entries(targets));
  differsSince = null;
}

/** Choose a drivable controller, and end driving if the server's state requires it. */
export function review(now: Status | null, wallTimeMs: number): void {
  if (!isDriving.value) return;
  const controller = controllerOf(now);
  if (shown.isPast.value) {
    disable("past");
  } else if (now === null) {
    disable("lost");
  } else if (silence.value !== null) {
    disable("silent");
  } else if (now.stopped) {
    disable("stopped");
  } else if (controller === undefined || !canDrive(controller)) {
    if (goals.value !== null) release();
  } else if (goals.value === null) {
    take(controller, now);
  } else if (wallTimeMs < settlesUntil) {
    takeTargets(now);
  } else if (now.paused || !isElsewhere(now, wallTimeMs)) {
    differsSince = null;
  } else if (differsSince === null && hasStopped(now)) {
    takeTargets(now); // what this page wanted was aborted: nobody else moves the robot
  } else {
    differsSince ??= wallTimeMs;
    if (wallTimeMs - differsSince > ELSEWHERE_AFTER_MS) disable("elsewhere");
  }
}

/** Watch for events that end driving; call the result to end the watch. */
export function watchDriving(): () => void {
  const ends = [
    effect(() => {
      const now = connectionState.value === "open" ? status.value : null;
      review(now, performance.now());
    }),
    effect(() => {
      // the sliders do not stay at targets that the robot will not reach
      const now = status.peek();
      if (refusals.value > 0 && now !== null) takeTargets(now);
    }),
    effect(() => {
      if (unreached.value > 0) followPlan();
    }),
    frames.listen((frame) => {
      if (frame.time < lastTime - 1e-9) disable("reset");
      lastTime = frame.time;
      review(status.value, performance.now());
    }),
  ];
  return () => {
    for (const end of ends) end();
  };
}
