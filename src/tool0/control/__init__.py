"""The semantics of ros_control, independent of any engine and of ROS itself."""
