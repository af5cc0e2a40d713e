"""Kinematics of an arm: Jacobian, inverse kinematics, straight paths of its tool."""
