"""The web panel: its server, and the protocol between page and server."""
