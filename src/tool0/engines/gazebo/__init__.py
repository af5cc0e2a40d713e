"""Gazebo 11 as an engine: a real gzserver in lockstep with the control loop."""
