"""What sets up a machine or a workspace, and what runs there as a child process."""
