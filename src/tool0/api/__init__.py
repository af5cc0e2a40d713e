"""The Python API: handles for a robot and its parts, in this or another process."""
