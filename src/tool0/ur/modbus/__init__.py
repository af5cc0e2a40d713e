"""Modbus TCP, used by the gripper's server and by programs, which are clients."""
