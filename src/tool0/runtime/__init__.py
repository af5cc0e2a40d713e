"""The loop, its mailbox and its bus, and the facade that edges use."""
