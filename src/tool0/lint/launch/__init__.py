"""ROS 1 launch files as values.

The launch files are read like in roslaunch, but without ROS.
"""
