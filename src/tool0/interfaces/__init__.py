"""How others reach a running robot: web panel, socket, ROS 1."""
