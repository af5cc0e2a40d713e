"""Starts the ROS 2 interface in a separate process."""
