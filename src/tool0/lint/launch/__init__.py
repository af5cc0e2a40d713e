"""ROS 1 launch files as values.

The launch files are read as in roslaunch, but without ROS.
"""
