/** Edges around what is selected, drawn through everything. */
import { EdgesGeometry, LineBasicMaterial, LineSegments } from "three";
import type { SolidMesh } from "./robot";

/** Flatter edges are not drawn [deg]. */
const FLAT = 25;

export class Outline {
  private readonly material = new LineBasicMaterial({
    transparent: true,
    opacity: 0.8,
    depthTest: false,
    toneMapped: false,
  });
  private edges = new Map<SolidMesh, LineSegments>();

  paint(colour: string): void {
    this.material.color.set(colour);
  }

  /** Outline these meshes and no others. */
  show(meshes: readonly SolidMesh[]): void {
    for (const [mesh, edges] of this.edges) {
      if (meshes.includes(mesh)) continue;
      edges.removeFromParent();
      edges.geometry.dispose();
      this.edges.delete(mesh);
    }
    for (const mesh of meshes) {
      if (this.edges.has(mesh)) continue;
      const edges = new LineSegments(
        new EdgesGeometry(mesh.geometry, FLAT),
        this.material,
      );
      edges.renderOrder = 9;
      edges.raycast = () => undefined;
      mesh.add(edges);
      this.edges.set(mesh, edges);
    }
  }

  dispose(): void {
    this.show([]);
    this.material.dispose();
  }
}
