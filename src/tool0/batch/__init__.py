"""Many copies of a robot, simulated together."""
