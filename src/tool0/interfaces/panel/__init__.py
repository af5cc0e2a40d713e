"""The web page: its server, and the protocol that they speak."""
