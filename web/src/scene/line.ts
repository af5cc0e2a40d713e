/** A line of some pixels' width through points; three.js draws its own one pixel wide. */
import { Color } from "three";
import { Line2 } from "three/examples/jsm/lines/Line2.js";
import { LineGeometry } from "three/examples/jsm/lines/LineGeometry.js";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";

export interface LineLook {
  /** [px] */
  readonly width: number;
  /** Fades from its end to its begin. */
  readonly fades?: boolean;
  readonly dashed?: boolean;
}

export class ThickLine {
  readonly root: Line2;
  private readonly material: LineMaterial;
  private readonly colour = new Color();
  private readonly faded = new Color();

  constructor(private readonly look: LineLook) {
    this.material = new LineMaterial({
      linewidth: look.width,
      vertexColors: look.fades ?? false,
      dashed: look.dashed ?? false,
      dashSize: 0.012,
      gapSize: 0.008,
      toneMapped: false,
    });
    this.root = new Line2(new LineGeometry(), this.material);
    this.root.visible = false;
    this.root.frustumCulled = false;
    this.root.renderOrder = 5;
    this.root.raycast = () => undefined;
  }

  /** @param faded the colour of the begin of a line that fades */
  paint(colour: string, faded: string): void {
    this.colour.set(colour);
    this.faded.set(faded);
    if (!this.look.fades) this.material.color.set(colour);
  }

  /** Draw it through points, x y z of each [m]. */
  show(points: readonly number[]): void {
    this.root.visible = points.length >= 6;
    if (!this.root.visible) return;
    // the number of its segments is fixed: another number needs another geometry
    this.root.geometry.dispose();
    const geometry = new LineGeometry();
    geometry.setPositions(points as number[]);
    if (this.look.fades) geometry.setColors(this.coloursOf(points.length / 3));
    this.root.geometry = geometry;
    if (this.look.dashed) this.root.computeLineDistances();
  }

  private coloursOf(count: number): number[] {
    const colour = new Color();
    return Array.from({ length: count }).flatMap((_, index) => {
      const { r, g, b } = colour.lerpColors(
        this.faded,
        this.colour,
        index / (count - 1),
      );
      return [r, g, b];
    });
  }

  dispose(): void {
    this.root.geometry.dispose();
    this.material.dispose();
  }
}
