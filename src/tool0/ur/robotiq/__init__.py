"""The gripper with Robotiq's own interfaces: URCap socket and Modbus."""
