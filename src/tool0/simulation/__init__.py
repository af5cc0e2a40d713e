"""The simulation as a backend: handlers, core, loop and its mailbox."""
