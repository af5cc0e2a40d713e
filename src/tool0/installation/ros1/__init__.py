"""Finds and installs ROS 1 on this machine."""
