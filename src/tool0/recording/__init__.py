"""Recordings: MCAP files with ROS 2 messages, written from snapshots, and read."""
