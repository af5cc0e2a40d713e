"""Launch files of ROS 1 as values, read as roslaunch reads them, without ROS."""
