"""What this machine can run, what is missing, and the command that installs it.

Each probe looks at one thing, in a process of its own: one that crashes or hangs takes
nothing else with it.  Nothing is installed, and nothing stays running.
"""
