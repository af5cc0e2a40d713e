/** The robot of the URDF, posed by the values of its joints. */
import {
  Box3,
  type BufferGeometry,
  Group,
  Mesh,
  MeshPhongMaterial,
  type Object3D,
} from "three";
import URDFLoader, { type URDFLink, type URDFRobot } from "urdf-loader";
import type { RobotInfo } from "../protocol";
import { MODEL_LAYER } from "./layers";
import type { Materials, Solid } from "./materials";
import type { Meshes } from "./meshes";

/** COLLADA may have several materials in one mesh. */
export type SolidMesh = Mesh<BufferGeometry, Solid | Solid[]>;

function parsed(text: string, meshes: Meshes, part: "visual" | "collision") {
  const loading: Promise<unknown>[] = [];
  const failures: string[] = [];
  const loader = new URDFLoader();
  loader.parseVisual = part === "visual";
  loader.parseCollision = part === "collision";
  loader.loadMeshCb = (path, _manager, material, done) => {
    loading.push(
      meshes.load(path, material).then(done, (error: unknown) => {
        failures.push(error instanceof Error ? error.message : String(error));
      }),
    );
  };
  const robot = loader.parse(text);
  // use the server's values unchanged: like those of real joints, they may exceed a limit
  for (const joint of Object.values(robot.joints)) joint.ignoreLimits = true;
  return { robot, failures, loaded: Promise.all(loading) };
}

/** Return the meshes of an object and its children, but not those of further links. */
export function meshesOf(object: Object3D): SolidMesh[] {
  const found: SolidMesh[] = [];
  const visit = (one: Object3D) => {
    if (one instanceof Mesh) found.push(one as SolidMesh);
    for (const child of one.children) if (!("isURDFJoint" in child)) visit(child);
  };
  visit(object);
  return found;
}

export class Robot {
  /** Link → its visible meshes; links without any are left out. */
  readonly visuals = new Map<string, readonly SolidMesh[]>();
  private collision: Promise<Group[]> | undefined;

  private constructor(
    readonly root: URDFRobot,
    /** The same once more, for the goal; its mimic joints follow. */
    readonly twin: URDFRobot,
    /** Meshes that could not be read, and why. */
    readonly failures: readonly string[],
    private readonly info: RobotInfo,
    private readonly text: string,
    private readonly meshes: Meshes,
  ) {
    for (const [name, link] of Object.entries(root.links)) {
      const found = meshesOf(link);
      if (found.length > 0) this.visuals.set(name, found);
      for (const mesh of found) {
        mesh.userData.link = name;
        mesh.castShadow = mesh.receiveShadow = true;
        mesh.layers.enable(MODEL_LAYER);
      }
    }
    const known = new Set(info.joints.map((joint) => joint.name));
    for (const joint of Object.values(root.joints)) {
      joint.mimicJoints = joint.mimicJoints.filter((one) => !known.has(one.name));
    }
  }

  /** @param text the URDF, its meshes being paths on the server */
  static async load(
    info: RobotInfo,
    text: string,
    meshes: Meshes,
    materials: Materials,
  ): Promise<Robot> {
    const { robot, failures, loaded } = parsed(text, meshes, "visual");
    await loaded;
    robot.traverse((object) => {
      if (object instanceof Mesh && object.material instanceof MeshPhongMaterial) {
        object.material = materials.ofUrdf(object.material);
      }
    });
    const twin = robot.clone();
    for (const joint of Object.values(twin.joints)) joint.ignoreLimits = true;
    return new Robot(robot, twin, failures, info, text, meshes);
  }

  /** Put the joints where `values` says, in the order of `info.joints`. */
  pose(values: ArrayLike<number>): void {
    this.info.joints.forEach((joint, index) => {
      this.root.joints[joint.name]?.setJointValue(values[index] ?? 0);
    });
  }

  link(name: string): URDFLink | undefined {
    return this.root.links[name];
  }

  /** Return what surrounds the meshes of `under` and all that hangs on it. */
  boxOf(under: Object3D): Box3 {
    under.updateWorldMatrix(true, true);
    const box = new Box3();
    under.traverseVisible((object) => {
      if (object instanceof Mesh) box.expandByObject(object, true);
    });
    return box;
  }

  /** Show the collision shapes, which are loaded on first use, or hide them. */
  async showCollision(visible: boolean, look: (mesh: Mesh) => void): Promise<void> {
    if (!visible && !this.collision) return;
    this.collision ??= this.readCollision(look);
    for (const group of await this.collision) group.visible = visible;
  }

  private async readCollision(look: (mesh: Mesh) => void): Promise<Group[]> {
    const { robot, loaded } = parsed(this.text, this.meshes, "collision");
    await loaded;
    return Object.entries(robot.links).map(([name, link]) => {
      const group = new Group();
      for (const child of [...link.children]) {
        if ("isURDFCollider" in child) group.add(child);
      }
      for (const mesh of meshesOf(group)) look(mesh);
      this.root.links[name]?.add(group);
      return group;
    });
  }
}
