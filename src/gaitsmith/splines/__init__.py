"""Curves: polynomials, the splines of planned joints, and the two quartics of the gait template."""

from gaitsmith.splines.quartic_pair import coefficients as coefficients
from gaitsmith.splines.quartic_pair import evaluate_pair as evaluate_pair
from gaitsmith.splines.quartic_pair import time_vectors as time_vectors
from gaitsmith.splines.quartic_pair import w_matrix as w_matrix
