"""Which ROS 1 a machine has, and how to install it."""
