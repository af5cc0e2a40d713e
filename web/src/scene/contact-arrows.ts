/** Arrows for the forces at contacts. */
import { Group, MeshBasicMaterial, Vector3 } from "three";
import type { Contact, ViewObject } from "../protocol";
import { Arrow } from "./arrow";
import type { Label } from "./labels";

/** Smaller forces are not drawn [N]. */
const LEAST = 0.05;
/** Of so many contacts the value is written. */
const LABELLED = 8;
/** Arrows that are drawn, the largest first. */
const MOST = 60;

/** A force on a body, where it acts, in the root's axes. */
export interface Force {
  readonly on: string;
  readonly by: string;
  readonly point: readonly [number, number, number];
  /** [N] */
  readonly force: readonly [number, number, number];
  readonly size: number;
}

/**
 * Return the forces to draw, largest first.
 *
 * Of the two bodies at a contact, the arrow shows the force on the one that can be moved
 * most easily: an object, then a link, then what is fixed.
 */
export function forcesOf(
  contacts: readonly Contact[],
  objects: readonly ViewObject[],
  links: ReadonlySet<string>,
): Force[] {
  const movable = new Set(
    objects.filter(({ mass }) => mass !== null).map(({ name }) => name),
  );
  const rank = (body: string) => (movable.has(body) ? 2 : links.has(body) ? 1 : 0);
  return contacts
    .map(({ first, second, point, force }): Force => {
      const size = Math.hypot(...force);
      if (rank(first) <= rank(second)) {
        return { on: second, by: first, point, force, size };
      }
      const [x, y, z] = force;
      return { on: first, by: second, point, force: [-x, -y, -z], size };
    })
    .filter(({ size }) => size >= LEAST)
    .sort((one, other) => other.size - one.size)
    .slice(0, MOST);
}

export class ContactArrows {
  readonly root = new Group();
  private readonly material = new MeshBasicMaterial({
    depthTest: false,
    transparent: true,
    opacity: 0.9,
    toneMapped: false,
  });
  private readonly arrows: Arrow[] = [];
  private forces: readonly Force[] = [];

  paint(colour: string): void {
    this.material.color.set(colour);
  }

  show(forces: readonly Force[]): void {
    this.forces = forces;
    while (this.arrows.length < forces.length) {
      const arrow = new Arrow(this.material);
      this.arrows.push(arrow);
      this.root.add(arrow.root);
    }
    this.arrows.forEach((arrow, index) => {
      const force = forces[index];
      arrow.root.visible = force !== undefined;
      if (force) arrow.aim(new Vector3(...force.point), new Vector3(...force.force));
    });
  }

  get labels(): Label[] {
    return this.forces.slice(0, LABELLED).flatMap(({ size }, index) => {
      const at = this.arrows[index]?.tip;
      return at ? [{ text: `${size.toFixed(1)} N`, at }] : [];
    });
  }

  dispose(): void {
    for (const arrow of this.arrows) arrow.dispose();
    this.material.dispose();
  }
}
