"""A native implementation of ur_rtde's control program."""
