"""Clients for robots and grippers, and message formats for clients and servers."""
