"""The ROS 1 of a machine, and its installation."""
