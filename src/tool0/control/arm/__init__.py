"""Arm motion for external motion planners: paths, streams and forces."""
