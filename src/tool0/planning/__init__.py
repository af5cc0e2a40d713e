"""Motions that avoid collisions: the collision world, the search, the timing."""
