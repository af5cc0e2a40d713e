"""The loop, its mailbox and its bus, and the facade for the interfaces."""
