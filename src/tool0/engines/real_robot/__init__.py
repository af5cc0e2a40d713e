"""A real UR and its gripper behind the ``Engine`` protocol."""
