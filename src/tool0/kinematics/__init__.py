"""Kinematics of an arm: forward kinematics, Jacobian and inverse kinematics."""
