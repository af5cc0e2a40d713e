"""Modbus TCP, of the gripper's server and of programs that are clients."""
