"""UR's real-time data exchange (RTDE)."""
