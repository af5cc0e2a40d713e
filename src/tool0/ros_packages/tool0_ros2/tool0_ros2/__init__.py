"""The ROS 2 node for a robot that tool0 simulates.

It runs with the Python of a ROS 2 installation, imports only the standard library,
rclpy and message packages, and talks to the simulation over its Unix socket.  The node
only translates; the controllers run in the simulation.
"""
