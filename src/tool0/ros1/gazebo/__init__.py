"""The services and topics of gazebo_ros, with either engine."""
