"""Motions as data: the robot as the planner sees it, phases and conditions, and the paper's motions."""
