"""Measurements: cameras, wrenches, collisions, grasps and stalls."""
