"""Setting up a machine or a workspace, and running child processes."""
