/** The rows of the tree, and how keys move among them, as ARIA's tree pattern asks. */
import type { UrdfJoint, UrdfModel } from "../urdf";

export interface TreeRow {
  readonly link: string;
  readonly joint: UrdfJoint | null;
  /** 1 for the root. */
  readonly level: number;
  readonly hasChildren: boolean;
  readonly place: number;
  readonly siblings: number;
}

/** Return the rows that are seen, top to bottom. */
export function visibleRows(
  model: UrdfModel,
  folded: ReadonlySet<string>,
): readonly TreeRow[] {
  const rows: TreeRow[] = [];
  const visit = (
    link: string,
    joint: UrdfJoint | null,
    level: number,
    place: number,
    siblings: number,
  ) => {
    const children = model.childJoints.get(link) ?? [];
    const hasChildren = children.length > 0;
    rows.push({ link, joint, level, hasChildren, place, siblings });
    if (folded.has(link)) return;
    children.forEach((child, index) => {
      visit(child.child, child, level + 1, index + 1, children.length);
    });
  };
  visit(model.root, null, 1, 1, 1);
  return rows;
}

export type TreeMove =
  { readonly focus: string } | { readonly fold: string } | { readonly unfold: string };

/** Return what a key does at the row of `link`, or undefined for other keys. */
export function moveOf(
  key: string,
  link: string,
  rows: readonly TreeRow[],
  folded: ReadonlySet<string>,
): TreeMove | undefined {
  const at = rows.findIndex((row) => row.link === link);
  const row = rows[at];
  if (row === undefined) return undefined;
  const focus = (to: TreeRow | undefined) => (to ? { focus: to.link } : undefined);
  switch (key) {
    case "ArrowDown":
      return focus(rows[at + 1]);
    case "ArrowUp":
      return focus(rows[at - 1]);
    case "Home":
      return focus(rows[0]);
    case "End":
      return focus(rows.at(-1));
    case "ArrowRight":
      if (!row.hasChildren) return undefined;
      return folded.has(link) ? { unfold: link } : focus(rows[at + 1]);
    case "ArrowLeft":
      if (row.hasChildren && !folded.has(link)) return { fold: link };
      return row.joint ? { focus: row.joint.parent } : undefined;
    default:
      return undefined;
  }
}
