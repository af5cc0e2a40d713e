"""The server for all connections over the Unix socket and over WebSocket."""
