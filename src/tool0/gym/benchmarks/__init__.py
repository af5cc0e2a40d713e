"""Tasks beyond cubes: insertion, assembly, a drawer, clutter and a handover."""
