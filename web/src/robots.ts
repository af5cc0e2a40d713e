/** The robots of a cell, and the one that the controls move. */
import { computed, signal } from "@preact/signals";
import type { ControllerInfo, RobotPartsInfo } from "./protocol";
import { status, view } from "./store";
import type { UrdfModel } from "./urdf";

/** The robots to choose from; empty unless there are several. */
export const robots = computed<readonly RobotPartsInfo[]>(() => {
  const all = view.value?.robot.robots ?? [];
  return all.length > 1 ? all : [];
});

/** The robot that the user chose, if it still exists. */
export const chosenRobot = signal<string | null>(null);

/** The robot that the controls move; null unless there are several. */
export const selected = computed<RobotPartsInfo | null>(
  () =>
    robots.value.find((robot) => robot.name === chosenRobot.value) ??
    robots.value[0] ??
    null,
);

/** Joint → its robot. */
const owners = computed<ReadonlyMap<string, RobotPartsInfo>>(
  () =>
    new Map(
      robots.value.flatMap((robot) =>
        robot.joints.map((joint) => [joint, robot] as const),
      ),
    ),
);

/** Return the robot of a joint; undefined if it belongs to none, or there are not several. */
export function ownerOf(joint: string): RobotPartsInfo | undefined {
  return owners.value.get(joint);
}

/** Return the only robot that a controller claims joints of, or undefined. */
export function robotOf(controller: ControllerInfo): RobotPartsInfo | undefined {
  const [first, ...more] = new Set(controller.joints.map(ownerOf));
  return more.length === 0 ? first : undefined;
}

/** Return whether the selected robot has the joint, or no robot has it. */
export function isOurs(joint: string): boolean {
  return [undefined, selected.value ?? undefined].includes(ownerOf(joint));
}

/** Return whether a controller claims joints of the selected robot, or of none. */
export function isOurController({ joints }: ControllerInfo): boolean {
  return joints.length === 0 || joints.some(isOurs);
}

/** Return a robot's name, and of what it consists if that is known. */
export function titleOf({ name, title }: RobotPartsInfo): string {
  return title === null ? name : `${name}: ${title}`;
}

/** Return a joint's or link's name without the prefix of its robot. */
export function withoutPrefix(name: string, robot = selected.value): string {
  const prefix = robot?.prefix ?? "";
  return name.startsWith(prefix) ? name.slice(prefix.length) : name;
}

/** Robots with a joint that pushes at its limit and does not move. */
export const stalled = computed<ReadonlySet<RobotPartsInfo | undefined>>(
  () => new Set(status.value?.stalls.map((stall) => ownerOf(stall.joint))),
);

/** Return the robot that a link is part of; undefined for links of none. */
export function robotOfLink(
  model: UrdfModel | null,
  link: string,
): RobotPartsInfo | undefined {
  for (let at: string | undefined = link; at !== undefined;) {
    const robot = robots.value.find(({ base }) => base === at);
    if (robot) return robot;
    at = model?.parentJoint.get(at)?.parent;
  }
  return undefined;
}
