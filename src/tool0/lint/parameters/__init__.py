"""Rules for the YAML of ros_control (ROS 1) and ros2_control."""
