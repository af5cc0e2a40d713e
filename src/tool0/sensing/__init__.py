"""Measurements: snapshots, cameras, wrench, grasps."""
