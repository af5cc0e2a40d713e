"""A UR arm with a Robotiq gripper in simulation, driven by real controllers."""
