"""From a motion to a nonlinear program: splines, bounds, boundary conditions, rows and derivatives."""
