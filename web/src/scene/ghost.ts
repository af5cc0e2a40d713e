/** The commanded goal: a second, translucent robot, where it differs from the first. */
import { LessEqualDepth, Mesh, MeshBasicMaterial, MeshLambertMaterial } from "three";
import { meshesOf, type Robot, type SolidMesh } from "./robot";

/** Links that lie closer than this are not doubled: they would only flicker [m, rad]. */
const SAME = 0.012;

export class Ghost {
  /** Fills the depth buffer first, so that no far side shines through. */
  private readonly veil = new MeshBasicMaterial({
    colorWrite: false,
    transparent: true,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 2,
  });
  private readonly look = new MeshLambertMaterial({
    transparent: true,
    opacity: 0.34,
    depthFunc: LessEqualDepth,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 2,
  });
  private readonly parts = new Map<string, SolidMesh[]>();

  constructor(private readonly robot: Robot) {
    robot.twin.visible = false;
    for (const [name, link] of Object.entries(robot.twin.links)) {
      const meshes = meshesOf(link);
      if (meshes.length === 0) continue;
      for (const mesh of meshes) {
        const veil = new Mesh(mesh.geometry, this.veil);
        veil.renderOrder = 1;
        mesh.material = this.look;
        mesh.renderOrder = 2;
        mesh.castShadow = mesh.receiveShadow = false;
        mesh.layers.set(0);
        mesh.add(veil);
      }
      this.parts.set(name, meshes);
    }
  }

  paint(colour: string): void {
    this.look.color.set(colour);
    this.look.emissive.set(colour);
    this.look.emissiveIntensity = 0.25;
  }

  /** Show the target of the robot; undefined: it has arrived.  Return whether anything changed. */
  show(goal: ReadonlyMap<string, number> | undefined): boolean {
    const { root, twin } = this.robot;
    const was = twin.visible;
    twin.visible = goal !== undefined;
    if (!goal) return was;
    for (const [name, position] of goal) twin.joints[name]?.setJointValue(position);
    root.updateWorldMatrix(true, true);
    twin.updateWorldMatrix(true, true);
    for (const [name, meshes] of this.parts) {
      const there = twin.links[name]?.matrixWorld.elements ?? [];
      const here = root.links[name]?.matrixWorld.elements ?? [];
      const apart = there.some((one, i) => Math.abs(one - (here[i] ?? 0)) > SAME);
      for (const mesh of meshes) mesh.visible = apart;
    }
    return true;
  }

  dispose(): void {
    this.veil.dispose();
    this.look.dispose();
  }
}
