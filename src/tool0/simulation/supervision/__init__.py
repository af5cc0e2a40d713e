"""Supervises that joints follow and arms touch only what they may; names causes."""
