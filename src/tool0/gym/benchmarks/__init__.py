"""Tasks that need more than a cube: insertion, assembly, a drawer, clutter."""
