"""Motions that avoid collisions: the collision world, the search and the timing."""
