"""Finds faults in launch files, robots, controllers and packages before use."""
