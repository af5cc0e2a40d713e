"""Gazebo 11 as an engine: a real gzserver in lock-step with the loop."""
