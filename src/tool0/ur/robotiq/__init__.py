"""The gripper as Robotiq's own interfaces show it: URCap socket and Modbus."""
