"""The compiled tick: laws, drives and physics steps without Python."""
