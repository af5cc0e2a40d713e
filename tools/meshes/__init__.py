"""Low-poly meshes and collision primitives, drawn from a few parameters."""
