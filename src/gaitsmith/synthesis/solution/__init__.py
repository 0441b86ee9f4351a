"""Solving: IPOPT cold, SQP warm, points added between the points, closure, and why there is no solution."""
