"""The services and topics of gazebo_ros, for both physics engines."""
