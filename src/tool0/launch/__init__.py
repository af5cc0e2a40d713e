"""Launch files of ROS 1, read without ROS: what roslaunch would do, and what is wrong.

``reader.read_launch`` reads a file and all that it includes, ``model`` holds what it
says, ``parameters`` what the parameter server would get, ``flow`` where each argument
ends up, ``comments`` the elements that somebody commented out.
"""
