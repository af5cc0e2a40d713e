"""The semantics of ros_control; knows no engine and no ROS."""
