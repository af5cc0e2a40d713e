"""ROS 1: the controllers of ros_control, their YAML and its linter."""
