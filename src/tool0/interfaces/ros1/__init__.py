"""The ROS 1 edge: what ros_control and gazebo_ros present, over one running robot."""
