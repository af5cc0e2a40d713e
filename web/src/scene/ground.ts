/** The ground: a grid, and what catches the shadow. */
import { Group, Mesh, PlaneGeometry, ShadowMaterial } from "three";
import { type GridColours, gridFor, REACH } from "./grid";
import type { Quality } from "./quality";

export class Ground {
  readonly root = new Group();
  private readonly grid;
  private readonly shade = new ShadowMaterial({ depthWrite: false });
  private readonly plane = new PlaneGeometry(2 * REACH, 2 * REACH);

  /** @param solid whether there is a ground, or only a grid to see where things are */
  constructor(quality: Quality, solid: boolean) {
    this.grid = gridFor(quality);
    this.grid.object.renderOrder = -1;
    this.root.add(this.grid.object);
    if (quality === "low" || !solid) return;
    const shade = new Mesh(this.plane, this.shade);
    shade.receiveShadow = true;
    shade.renderOrder = -2;
    this.root.add(shade);
  }

  paint(colours: GridColours & { dark: boolean }): void {
    this.grid.paint(colours);
    this.shade.opacity = colours.dark ? 0.5 : 0.2;
  }

  dispose(): void {
    this.grid.dispose();
    this.plane.dispose();
    this.shade.dispose();
  }
}
