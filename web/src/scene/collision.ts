/** How collision shapes look: translucent, with edges that shine through everything. */
import {
  EdgesGeometry,
  LineBasicMaterial,
  LineSegments,
  type Mesh,
  MeshLambertMaterial,
} from "three";

/** Flatter edges are not drawn [deg]. */
const FLAT = 30;

export class CollisionLook {
  private readonly faces = new MeshLambertMaterial({
    transparent: true,
    opacity: 0.3,
    depthWrite: false,
    // in front of the visible shape, where both have one surface
    polygonOffset: true,
    polygonOffsetFactor: -2,
    polygonOffsetUnits: -8,
  });
  private readonly edges = new LineBasicMaterial({
    transparent: true,
    opacity: 0.55,
    depthTest: false,
    depthWrite: false,
    toneMapped: false,
  });

  /** Make `mesh` look so. */
  dress(mesh: Mesh): void {
    mesh.material = this.faces;
    mesh.renderOrder = 3;
    const edges = new LineSegments(new EdgesGeometry(mesh.geometry, FLAT), this.edges);
    edges.renderOrder = 4;
    mesh.add(edges);
  }

  paint(colour: string): void {
    this.faces.color.set(colour);
    this.edges.color.set(colour);
  }

  dispose(): void {
    this.faces.dispose();
    this.edges.dispose();
  }
}
