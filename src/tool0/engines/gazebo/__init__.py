"""Gazebo 11 as an engine: a gzserver process in lockstep with the control loop."""
