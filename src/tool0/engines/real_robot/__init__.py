"""Implementation of the ``Engine`` protocol for a real UR and its gripper."""
