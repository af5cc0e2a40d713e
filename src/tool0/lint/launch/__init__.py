"""ROS 1 launch files as values, read as roslaunch reads them, but without ROS."""
