"""Reads the syntax trees of ROS 2 Python launch files, without executing the files."""
