"""Modbus TCP: shared by the gripper's server and by programs, which are clients."""
