"""Sets up machines and workspaces, and runs child processes."""
