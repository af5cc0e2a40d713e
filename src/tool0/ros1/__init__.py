"""ROS 1: the interfaces of ros_control and gazebo_ros for one running robot."""
