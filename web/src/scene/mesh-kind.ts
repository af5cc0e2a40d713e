/** Which reader a mesh file needs. */
export type MeshKind = "stl" | "dae" | "obj";

const KINDS: readonly MeshKind[] = ["stl", "dae", "obj"];

/** Return the kind of the file at `url`, or undefined for one that we cannot read. */
export function meshKind(url: string): MeshKind | undefined {
  const path = url.replace(/[?#].*$/, "").toLowerCase();
  return KINDS.find((kind) => path.endsWith(`.${kind}`));
}
