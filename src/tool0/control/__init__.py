"""Semantics of ros_control, independent of any physics engine and of ROS."""
