"""Writing and reading of recordings: MCAP files with ROS 2 messages."""
