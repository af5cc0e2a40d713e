"""The ROS 2 interface: a process of its own, which these modules start."""
