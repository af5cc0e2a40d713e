"""The ROS 1 interfaces of ros_control and gazebo_ros for one running robot."""
