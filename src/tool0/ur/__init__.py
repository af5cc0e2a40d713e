"""The interfaces of a UR's control box, in a process of their own: RTDE and others."""
