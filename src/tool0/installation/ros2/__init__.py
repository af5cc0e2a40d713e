"""Finds a ROS 2, installs one from PyPI's wheels, and sets its environment."""
