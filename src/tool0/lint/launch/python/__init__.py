"""Reads Python launch files of ROS 2 by their syntax tree, without executing them."""
