"""The gait template's curve: two quartics joined twice continuously differentiable."""

from gaitsmith.splines.quartic_pair import coefficients as coefficients
from gaitsmith.splines.quartic_pair import evaluate_pair as evaluate_pair
from gaitsmith.splines.quartic_pair import power_basis as power_basis
from gaitsmith.splines.quartic_pair import w_matrix as w_matrix
