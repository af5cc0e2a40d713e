"""The simulation as a backend: request handlers, core, and loop with a mailbox."""
