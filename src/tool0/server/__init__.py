"""One server for every connection, over the Unix socket and over WebSocket."""
