/** Changes of the scene that this page makes, and how to undo them. */
import { computed, signal } from "@preact/signals";
import { connection } from "./connection";
import { frames } from "./frames";
import { fromQuaternion, toRpy } from "./kinematics";
import type { Method } from "./messages";
import type { Target } from "./moving";
import { report } from "./notices";
import type { AddObject, ErrorInfo, Requests, ShapeInfo, ViewObject } from "./protocol";
import { select } from "./selection";
import { scene, view } from "./store";

type SceneMethod = Extract<Method, "add_object" | "remove_object" | "place_object">;
type Call = {
  [M in SceneMethod]: { readonly method: M; readonly params: Requests[M] };
}[SceneMethod];

/** Requests that change the scene, and those that change it back. */
interface Edit {
  readonly redo: readonly Call[];
  readonly undo: readonly Call[];
}

/** Edits that are kept. */
const MOST = 100;
/** A copy stands beside its original by this much of its own size. */
const ASIDE = 1.2;

const done = signal<readonly Edit[]>([]);
const undone = signal<readonly Edit[]>([]);
/** Edits that wait for their answer. */
const pending = signal(0);
/** Ends with the last of them. */
let last: Promise<unknown> = Promise.resolve();
export const canUndo = computed(() => pending.value > 0 || done.value.length > 0);
export const canRedo = computed(() => undone.value.length > 0);

// another server, or another robot: the objects are others
view.subscribe(() => {
  done.value = undone.value = [];
});

/** Send the requests, which the server executes in order; return why one was refused. */
async function carryOut(calls: readonly Call[]): Promise<ErrorInfo | null> {
  const problems = await Promise.all(
    calls.map(({ method, params }) => connection.request(method, params)),
  );
  return problems.find((problem) => problem !== null) ?? null;
}

/** Begin when what was begun before has ended, so that an undo knows what it undoes. */
function inOrder<T>(begin: () => Promise<T>): Promise<T> {
  const begun = pending.value > 0 ? last.then(begin) : begin();
  pending.value += 1;
  const result = begun.finally(() => {
    pending.value -= 1;
  });
  last = result.catch(() => undefined);
  return result;
}

function perform(make: () => Edit): Promise<ErrorInfo | null> {
  return inOrder(async () => {
    const edit = make();
    const problem = await carryOut(edit.redo);
    if (problem === null) {
      done.value = [...done.value, edit].slice(-MOST);
      undone.value = [];
    }
    return problem;
  });
}

/** Undo the last edit; one that cannot be undone is reported, and forgotten. */
export function undo(): Promise<void> {
  return inOrder(async () => {
    const edit = done.value.at(-1);
    if (!edit) return;
    done.value = done.value.slice(0, -1);
    if (await succeeds(edit.undo)) undone.value = [...undone.value, edit];
  });
}

/** Do again what was undone last. */
export function redo(): Promise<void> {
  return inOrder(async () => {
    const edit = undone.value.at(-1);
    if (!edit) return;
    undone.value = undone.value.slice(0, -1);
    if (await succeeds(edit.redo)) done.value = [...done.value, edit];
  });
}

async function succeeds(calls: readonly Call[]): Promise<boolean> {
  const problem = await carryOut(calls);
  reportRefusal(problem);
  return problem === null;
}

// ---- edits --------------------------------------------------------------------------

/** Add an object; return why it was refused. */
export function addObject(params: AddObject): Promise<ErrorInfo | null> {
  return perform(() => adding(params));
}

function adding(params: AddObject): Edit {
  const undo: Call = { method: "remove_object", params: { name: params.name } };
  return { redo: [{ method: "add_object", params }], undo: [undo] };
}

/** Place an object; return why it was refused. */
export function placeObject(name: string, to: Target): Promise<ErrorInfo | null> {
  const from = targetOf(name);
  return perform(() => ({
    redo: [placing(name, to)],
    undo: from ? [placing(name, from)] : [],
  }));
}

/** Remove objects, and report a refusal. */
export async function removeObjects(objects: readonly ViewObject[]): Promise<void> {
  const redo = objects.map(({ name }): Call => ({
    method: "remove_object",
    params: { name },
  }));
  const undo = objects.map((object): Call => ({
    method: "add_object",
    params: copyOf(object),
  }));
  reportRefusal(await perform(() => ({ redo, undo })));
}

/** Add a copy beside an object, select it, and report a refusal. */
export async function duplicateObject(object: ViewObject): Promise<void> {
  const copy = copyOf(object);
  let { name } = object;
  const [x = 0, y = 0, z = 0] = copy.xyz ?? [];
  const xyz: [number, number, number] = [x, y + ASIDE * widthOf(object.shape), z];
  const problem = await perform(() => {
    name = freeName(object.name.replace(/ \d+$/, ""), addedNames());
    return adding({ ...copy, name, xyz });
  });
  reportRefusal(problem);
  if (problem === null) select({ kind: "object", name });
}

function reportRefusal(problem: ErrorInfo | null): void {
  if (problem) report("error", problem.message);
}

function placing(name: string, { position, rpy }: Target): Call {
  return {
    method: "place_object",
    params: { name, xyz: [...position], rpy: [...rpy] },
  };
}

/** Return the request that adds the same object where it is now. */
function copyOf({ name, shape, mass, friction, rgba }: ViewObject): AddObject {
  const { position, rpy } = targetOf(name) ?? { position: [0, 0, 0], rpy: [0, 0, 0] };
  return {
    name,
    shape: requestShape(shape),
    xyz: [...position],
    rpy: [...rpy],
    mass,
    friction,
    rgba,
  };
}

type RequestShape = AddObject["shape"];
type SingleShape = Exclude<RequestShape, { kind: "compound" }>;

function requestShape(shape: ShapeInfo): RequestShape {
  if (shape.kind !== "compound") return singleShape(shape);
  const parts = (shape.parts ?? []).map((part) => ({
    ...part,
    shape: singleShape(part.shape),
  }));
  return { kind: "compound", parts };
}

function singleShape({ kind, size, radius, length, file }: ShapeInfo): SingleShape {
  switch (kind) {
    case "cylinder":
      return { kind, radius: radius ?? 0, length: length ?? 0 };
    case "sphere":
      return { kind, radius: radius ?? 0 };
    case "mesh":
      return { kind, file: file ?? "", scale: size ?? [1, 1, 1] };
    default:
      return { kind: "box", size: size ?? [1, 1, 1] };
  }
}

/** Return about how wide a shape is [m]. */
function widthOf(shape: ShapeInfo): number {
  if (shape.kind === "box") return Math.hypot(...(shape.size ?? []).slice(0, 2));
  if (shape.radius != null) return 2 * shape.radius;
  const reaches = (shape.parts ?? []).map(
    (part) => Math.hypot(...part.xyz) + widthOf(part.shape) / 2,
  );
  return 2 * Math.max(0.05, ...reaches);
}

/** Return the names of what was added here; the scene may not show all of it yet. */
function addedNames(): string[] {
  return done
    .peek()
    .flatMap(({ redo }) => redo)
    .flatMap(({ method, params }) => (method === "add_object" ? [params.name] : []));
}

/** Return a name that no object has, and no other: `box`, `box 2`, …. */
export function freeName(wanted: string, others: readonly string[] = []): string {
  const names = scene.value?.objects.map((object) => object.name) ?? [];
  const taken = new Set([...names, ...others]);
  if (!taken.has(wanted)) return wanted;
  let number = 2;
  while (taken.has(`${wanted} ${String(number)}`)) number += 1;
  return `${wanted} ${String(number)}`;
}

/** Return the pose of an object in a frame of the current scene. */
export function targetOf(name: string, frame = frames.latest): Target | undefined {
  const now = scene.peek();
  if (frame === undefined || frame.scene_number !== now?.number) return undefined;
  const pose = frame.objects[now.objects.findIndex((object) => object.name === name)];
  return pose && { position: pose[0], rpy: toRpy(fromQuaternion(pose[1])) };
}
