"""Legs: forward kinematics, inverse kinematics, standing posture."""
