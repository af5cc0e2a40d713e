"""ROS 2 packages for colcon."""
