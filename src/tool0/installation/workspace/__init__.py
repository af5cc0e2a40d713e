"""Writes the ROS packages that tool0 reads into a person's catkin workspace."""
