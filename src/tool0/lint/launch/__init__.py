"""ROS 1 launch files as values.

They are read like roslaunch reads them, but without ROS.
"""
