"""Finds or installs a ROS 2, and sets its environment."""
