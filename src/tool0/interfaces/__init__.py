"""Interfaces to a running robot: web panel, socket, ROS 1."""
