"""Packages of ROS 2, for colcon."""
