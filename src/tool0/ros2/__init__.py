"""The ROS 2 interface, which runs in a separate process that these modules start."""
