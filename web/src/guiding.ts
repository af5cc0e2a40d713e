/** Hand guiding: an arm that gives way, and the spring by which the user pulls it. */
import { effect, signal } from "@preact/signals";
import { connection, sendRequest } from "./connection";
import { shownBox } from "./control-box";
import { mayMove } from "./driving";
import { frames } from "./frames";
import { linkPose, pointAt } from "./kinematics";
import { model } from "./model";
import { jointIndex, status } from "./store";
import type { Vector } from "./urdf";

/** As the control box shows who has the arm. */
const TAKEN_BY = "hand guiding";
/** Of the spring between the arm and the pointer [N/m]. */
const STIFFNESS = 250;
/** [N] */
const LARGEST_FORCE = 80;
/** Between two targets of the stream [ms]. */
const INTERVAL_MS = 33;
/** How long the spring lasts if no other follows [s, at real time]. */
const DURATION = 0.25;

/** What the tool may do while the arm gives way: move and turn, move only, or turn only. */
export type Freedom = "all" | "position" | "rotation";
export const FREEDOMS: readonly Freedom[] = ["all", "position", "rotation"];
type Axes = [boolean, boolean, boolean, boolean, boolean, boolean];
const AXES: Record<Freedom, Axes> = {
  all: [true, true, true, true, true, true],
  position: [true, true, true, false, false, false],
  rotation: [false, false, false, true, true, true],
};

export const freedom = signal<Freedom>("all");
/** The arm that gives way, as requests name it; null if none does. */
export const guided = signal<string | null>(null);
/** The force of the spring [N]; null while nobody pulls. */
export const pullForce = signal<number | null>(null);

/** What the user pulls, by which point in the link's frame, and where to [m]. */
interface Pull {
  readonly link: string;
  readonly point: Vector;
  target: Vector;
}
let pull: Pull | null = null;
let timer: ReturnType<typeof setInterval> | undefined;

/** Let the shown arm give way. */
export async function startGuiding(): Promise<void> {
  const arm = shownBox.peek()?.arm;
  if (arm === undefined || !mayMove.peek()) return;
  if ((await sendRequest("take_arm", { arm, by: TAKEN_BY })) !== null) return;
  if (await giveWay(arm)) guided.value = arm;
  else await sendRequest("return_arm", { arm, by: TAKEN_BY });
}

async function giveWay(arm: string): Promise<boolean> {
  const axes = AXES[freedom.peek()];
  return (await sendRequest("start_freedrive", { arm, axes })) === null;
}

/** Give the arm back to its controllers, where it is. */
export async function endGuiding(): Promise<void> {
  const arm = guided.peek();
  if (arm === null) return;
  forget();
  await sendRequest("return_arm", { arm, by: TAKEN_BY });
}

/** Choose what the tool may do, also of an arm that gives way already. */
export function chooseFreedom(chosen: Freedom): void {
  freedom.value = chosen;
  if (guided.peek() !== null) void giveWay(guided.peek() ?? "");
}

function forget(): void {
  release();
  guided.value = null;
}

// ---- pulling ------------------------------------------------------------------------

/** Pull a link by a point in its frame; `target` is where the pointer has it [m]. */
export function grab(link: string, point: Vector, target: Vector): void {
  pull = { link, point, target };
  clearInterval(timer);
  timer = setInterval(send, INTERVAL_MS);
  send();
}

/** Pull to another place [m]. */
export function pullTo(target: Vector): void {
  if (pull) pull.target = target;
}

/** Let go: the arm stays. */
export function release(): void {
  clearInterval(timer);
  if (pull === null) return;
  const { link } = pull;
  pull = null;
  pullForce.value = null;
  void connection.request("clear_wrenches", { name: link });
}

/** Send the spring anew; the thread of the tick computes its force in every moment. */
function send(): void {
  const now = status.peek();
  if (pull === null || now === null) return;
  const { link, point, target } = pull;
  pullForce.value = forceOf(pull);
  connection.post("pull_link", {
    name: link,
    point: [...point],
    target: [...target],
    stiffness: STIFFNESS,
    max_force: LARGEST_FORCE,
    duration: DURATION * Math.max(1, now.real_time_factor),
  });
}

/** Return the force of the spring on a link that rests where it was seen last [N]. */
function forceOf({ link, point, target }: Pull): number {
  const [frame, tree] = [frames.latest, model.peek()];
  if (frame === undefined || tree === null) return 0;
  const positionOf = (joint: string) =>
    frame.position[jointIndex.peek().get(joint) ?? -1];
  const here = pointAt(linkPose(tree, link, positionOf), point);
  const way = target.map((part, i) => part - (here[i] ?? 0));
  return Math.min(LARGEST_FORCE, STIFFNESS * Math.hypot(...way));
}

/** Notice when somebody else ends it; call the result to end the watch. */
export function watchGuiding(): () => void {
  const ends = [
    effect(() => {
      if (!mayMove.value) void endGuiding();
    }),
    effect(() => {
      const boxes = status.value?.control_boxes;
      const box = boxes?.find(({ arm }) => arm === guided.peek());
      if (box?.taken_by !== TAKEN_BY && wasSeen) forget();
      wasSeen = box?.taken_by === TAKEN_BY;
    }),
  ];
  return () => {
    for (const end of ends) end();
  };
}

/** Whether a status has shown that the arm is taken: it comes after the reply. */
let wasSeen = false;
