"""Clients of the interfaces of robots and grippers, and the frames of both sides."""
