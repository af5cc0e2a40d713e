"""What a Python program holds: a robot and its parts, here or in another process."""
