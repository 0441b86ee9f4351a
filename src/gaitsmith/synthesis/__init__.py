"""Spline-parametric gait synthesis: motions as data, one constrained optimisation, and a certificate."""
