"""Reads Python launch files of ROS 2 by their syntax trees, without executing them."""
