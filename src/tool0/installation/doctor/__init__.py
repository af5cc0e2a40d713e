"""Reports what this machine can run, and the command that installs what is missing.

Nothing is installed, and nothing stays running.
"""
