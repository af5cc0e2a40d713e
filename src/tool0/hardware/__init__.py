"""The interface between control and physics: joint states in, efforts out."""
