"""Curves: polynomials, the splines of planned joints, and the two quartics of the gait template."""
