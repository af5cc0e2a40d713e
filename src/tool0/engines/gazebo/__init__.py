"""Gazebo 11 as an engine: real gzserver, in lock-step with the loop."""
