"""ROS 2: the controllers of ros2_control and their YAML."""
