"""The services and topics of gazebo_ros, over either engine."""
