"""Rigid-body dynamics of a floating-base tree, compiled once for all robots."""

from gaitsmith.dynamics.algorithms import update_dynamics as update_dynamics
from gaitsmith.dynamics.linear_algebra import factor_tree as factor_tree
from gaitsmith.dynamics.linear_algebra import solve_tree as solve_tree
from gaitsmith.dynamics.points import point_bias as point_bias
from gaitsmith.dynamics.points import point_jacobian as point_jacobian
from gaitsmith.dynamics.points import point_velocity as point_velocity
from gaitsmith.dynamics.points import sole_pose as sole_pose
from gaitsmith.dynamics.tree import Tree as Tree
from gaitsmith.dynamics.tree import TreeState as TreeState
from gaitsmith.dynamics.tree import make_tree_state as make_tree_state
from gaitsmith.dynamics.tree import read_tree as read_tree
