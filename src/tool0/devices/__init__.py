"""Clients for the interfaces of robots and grippers, and frames for both sides."""
