/** Which reader a mesh file needs. */
export type MeshKind = "stl" | "dae" | "obj";

const KINDS: readonly MeshKind[] = ["stl", "dae", "obj"];

/** Return the kind of the file at `url`, or undefined for one that we cannot read. */
export function meshKind(url: string): MeshKind | undefined {
  const path = url.replace(/[?#].*$/, "");
  const ending = path.slice(path.lastIndexOf(".") + 1).toLowerCase();
  return KINDS.find((kind) => kind === ending);
}
