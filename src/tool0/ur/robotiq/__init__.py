"""The gripper with Robotiq's interfaces: the URCap's socket and Modbus."""
