"""Installs Gazebo 11 without root, and checks whether Gazebo can run."""
