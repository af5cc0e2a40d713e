"""Gazebo 11 without root, and whether it can run here."""
