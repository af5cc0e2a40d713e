"""Tasks with more than cubes: insertion, assembly, a drawer, clutter, a handover."""
