"""Kinematics of an arm: forward kinematics, Jacobian, inverse kinematics."""
