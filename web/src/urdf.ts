/** What the tree shows of a URDF: links, joints, masses and limits.  Shapes are the scene's. */

export type Vector = readonly [number, number, number];

export interface Origin {
  readonly xyz: Vector;
  /** Roll, pitch and yaw about fixed axes [rad]. */
  readonly rpy: Vector;
}

export interface Inertial {
  /** [kg] */
  readonly mass: number;
  /** The centre of mass and the axes of `inertia`, in the link. */
  readonly origin: Origin;
  /** About the centre of mass, row by row [kg·m²]. */
  readonly inertia: readonly [Vector, Vector, Vector];
}

export interface UrdfLink {
  readonly name: string;
  readonly inertial: Inertial | null;
}

export interface UrdfJoint {
  readonly name: string;
  readonly type: string;
  readonly parent: string;
  readonly child: string;
  readonly origin: Origin;
  readonly axis: Vector;
  /** [rad | m]; null where there is none. */
  readonly lower: number | null;
  readonly upper: number | null;
  readonly velocity: number | null;
  readonly effort: number | null;
  readonly mimic: {
    readonly joint: string;
    readonly multiplier: number;
    readonly offset: number;
  } | null;
}

export interface UrdfModel {
  readonly root: string;
  readonly links: ReadonlyMap<string, UrdfLink>;
  /** Link → its parent joint. */
  readonly parentJoint: ReadonlyMap<string, UrdfJoint>;
  /** Link → its child joints, in the order of the file. */
  readonly childJoints: ReadonlyMap<string, readonly UrdfJoint[]>;
}

function child(element: Element | null, tag: string): Element | null {
  const children = element ? [...element.children] : [];
  return children.find((one) => one.tagName === tag) ?? null;
}

function number(element: Element | null, name: string): number | null {
  const text = element?.getAttribute(name) ?? null;
  const value = text === null || text.trim() === "" ? NaN : Number(text);
  return Number.isFinite(value) ? value : null;
}

function vector(element: Element | null, name: string, otherwise: Vector): Vector {
  const parts = (element?.getAttribute(name) ?? "").trim().split(/\s+/).map(Number);
  const [x, y, z] = parts;
  if (parts.length !== 3 || x === undefined || y === undefined || z === undefined) {
    return otherwise;
  }
  return [x, y, z].every(Number.isFinite) ? [x, y, z] : otherwise;
}

function originOf(element: Element | null): Origin {
  return {
    xyz: vector(element, "xyz", [0, 0, 0]),
    rpy: vector(element, "rpy", [0, 0, 0]),
  };
}

function inertialOf(element: Element | null): Inertial | null {
  const mass = number(child(element, "mass"), "value");
  if (mass === null) return null;
  const tensor = child(element, "inertia");
  const moment = (name: string) => number(tensor, name) ?? 0;
  const [xy, xz, yz] = [moment("ixy"), moment("ixz"), moment("iyz")];
  return {
    mass,
    origin: originOf(child(element, "origin")),
    inertia: [
      [moment("ixx"), xy, xz],
      [xy, moment("iyy"), yz],
      [xz, yz, moment("izz")],
    ],
  };
}

function jointOf(element: Element): UrdfJoint {
  const limit = child(element, "limit");
  const mimic = child(element, "mimic");
  const type = element.getAttribute("type") ?? "fixed";
  const turnsForever = type === "continuous";
  return {
    name: element.getAttribute("name") ?? "",
    type,
    parent: child(element, "parent")?.getAttribute("link") ?? "",
    child: child(element, "child")?.getAttribute("link") ?? "",
    origin: originOf(child(element, "origin")),
    axis: vector(child(element, "axis"), "xyz", [1, 0, 0]),
    lower: turnsForever ? null : number(limit, "lower"),
    upper: turnsForever ? null : number(limit, "upper"),
    velocity: number(limit, "velocity"),
    effort: number(limit, "effort"),
    mimic: mimic && {
      joint: mimic.getAttribute("joint") ?? "",
      multiplier: number(mimic, "multiplier") ?? 1,
      offset: number(mimic, "offset") ?? 0,
    },
  };
}

/** Return the tree in a URDF document.  Throws an Error with the reason if it is invalid. */
export function parseUrdf(text: string): UrdfModel {
  const robot = new DOMParser().parseFromString(
    text,
    "application/xml",
  ).documentElement;
  if (robot.tagName !== "robot") {
    throw new Error(`the document is <${robot.tagName}>, not <robot>`);
  }
  const elements = [...robot.children];
  const links = new Map<string, UrdfLink>();
  for (const element of elements.filter((one) => one.tagName === "link")) {
    const name = element.getAttribute("name") ?? "";
    links.set(name, { name, inertial: inertialOf(child(element, "inertial")) });
  }
  const parentJoint = new Map<string, UrdfJoint>();
  const childJoints = new Map<string, UrdfJoint[]>();
  for (const element of elements.filter((one) => one.tagName === "joint")) {
    const joint = jointOf(element);
    parentJoint.set(joint.child, joint);
    childJoints.set(joint.parent, [...(childJoints.get(joint.parent) ?? []), joint]);
  }
  const roots = [...links.keys()].filter((link) => !parentJoint.has(link));
  const [root] = roots;
  if (root === undefined || roots.length > 1) {
    throw new Error(
      `a tree has one root, this has ${roots.length}: ${roots.join(", ")}`,
    );
  }
  return { root, links, parentJoint, childJoints };
}
