"""The web panel, with its server and the protocol between the page and the server."""
