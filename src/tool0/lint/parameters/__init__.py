"""Rules for the YAML files of ros_control (ROS 1) and ros2_control (ROS 2)."""
