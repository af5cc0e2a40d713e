"""ROS 1: the controllers of ros_control, their YAML and the YAML linter."""
