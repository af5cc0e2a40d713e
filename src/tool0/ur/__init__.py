"""The interfaces of a UR control box, such as RTDE, served by a separate process."""
