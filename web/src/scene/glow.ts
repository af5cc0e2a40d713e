/** Meshes that are lit up: what the pointer is over, and what is selected. */
import type { Materials, Solid } from "./materials";
import type { SolidMesh } from "./robot";

export class Glow {
  private lit: ReadonlySet<SolidMesh> = new Set();
  private colour = "";

  constructor(private readonly materials: Materials) {}

  paint(colour: string): void {
    this.colour = colour;
    const again = this.lit;
    this.show([]);
    this.show(again);
  }

  /** Light up these meshes and no others; return whether that is a change. */
  show(meshes: Iterable<SolidMesh>): boolean {
    const next = new Set(meshes);
    const before = this.lit;
    if (next.size === before.size && [...next].every((mesh) => before.has(mesh))) {
      return false;
    }
    for (const mesh of before) {
      if (!next.has(mesh)) dress(mesh, (one) => this.materials.plainOf(one));
    }
    for (const mesh of next) {
      if (!before.has(mesh)) {
        dress(mesh, (one) => this.materials.glowingOf(one, this.colour));
      }
    }
    this.lit = next;
    return true;
  }
}

function dress(mesh: SolidMesh, change: (material: Solid) => Solid): void {
  const { material } = mesh;
  mesh.material = Array.isArray(material) ? material.map(change) : change(material);
}
