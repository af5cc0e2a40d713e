"""Launch files of ROS 1, read without ROS: what roslaunch would do, and what is wrong.

``reader.read_launch`` reads a file and all that it includes; ``model`` holds what it
says and ``packages`` where ``$(find …)`` looks.  From that come ``parameters``: what
the parameter server would get; ``xacro_files``: what xacro would read; ``flow``: what
uses an argument; ``contents`` and ``ways``: both explained, for ``tool0 explain``.
``comments`` holds the elements that somebody commented out.
"""
