"""The interface between control and physics.

The inputs of control are joint states; its outputs are efforts.
"""
