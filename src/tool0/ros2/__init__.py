"""The ROS 2 interface.  These modules start it in a separate process."""
