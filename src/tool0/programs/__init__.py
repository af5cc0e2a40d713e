"""Programs, as data: sequences of steps for one arm and its gripper."""
