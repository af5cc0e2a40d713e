"""What this machine can run, and the command that installs what is missing."""
