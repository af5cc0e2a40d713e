"""The ROS 2 node of a robot that tool0 simulates.

The node runs with the Python of a ROS 2 installation.  The node imports only the
standard library, rclpy and message packages.  The node communicates with the simulation
over the simulation's Unix socket.  The node only translates requests and data; the
controllers run in the simulation.
"""
