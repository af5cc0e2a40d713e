"""Programs: steps for one arm and its gripper, as data."""
