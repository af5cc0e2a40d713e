"""Launch files of ROS 1 as values, read as roslaunch reads them, without ROS.

``reader`` follows all includes and returns a ``model.LaunchFile`` with its findings;
``explanation`` and ``argument_flow`` describe it for ``tool0 explain``.
"""
