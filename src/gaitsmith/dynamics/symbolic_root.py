"""Roots of symbolic dynamics that move, and what a whole robot's motion adds up to, as CasADi expressions."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from gaitsmith.dynamics.rotation import rotation_matrix
from gaitsmith.dynamics.symbolic import BodyMotion, InverseDynamics, turn_about

Array = npt.NDArray[np.float64]


def flying(gravity: Any, rotation: Array, point: Array, pose: Any, rate: Any, pull: Any) -> BodyMotion:
    """Motion of a root of which a point moves freely.

    Args:
        gravity: (3,) inertial frame, m/s².
        rotation: (3, 3) root to inertial frame at pose zero.
        point: (3,) in the root's frame, m.
        pose, rate, pull: (6,) the point's x, y, z, m; yaw, pitch and roll, turned in this order, rad; two derivatives.
    """
    x, y, z = np.eye(3)
    sole = ca.mtimes([turn_about(z, pose[3]), turn_about(y, pose[4]), turn_about(x, pose[5])])
    up, side, ahead = ca.DM(z), ca.vertcat(-ca.sin(pose[3]), ca.cos(pose[3]), 0), sole[:, 0]
    spin = up * rate[3]
    bend = up * pull[3] + side * pull[4] + ahead * pull[5] + ca.cross(spin, side) * rate[4]
    spin = spin + side * rate[4]
    bend = bend + ca.cross(spin, ahead) * rate[5]
    R = ca.mtimes(sole, ca.DM(rotation))
    omega, alpha = ca.mtimes(R.T, spin + ahead * rate[5]), ca.mtimes(R.T, bend)
    arm = ca.DM(-point)
    across = ca.cross(omega, arm)
    pulled = ca.mtimes(R.T, pull[:3] - gravity) + ca.cross(alpha, arm) + ca.cross(omega, across)
    return BodyMotion(R, pose[:3] + ca.mtimes(R, arm), omega, ca.mtimes(R.T, rate[:3]) + across, alpha, pulled)


def momentum(model: Any, found: InverseDynamics) -> tuple[Any, Any, Any]:
    """Centre of mass, its velocity, and the angular momentum about the origin over the mass (3,), inertial frame."""
    place, speed, spin = ca.SX.zeros(3), ca.SX.zeros(3), ca.SX.zeros(3)
    mass = float(model.body_mass.sum())
    for body, m in found.motion.items():
        share, centre = float(model.body_mass[body]) / mass, ca.DM(model.body_ipos[body])
        axes = rotation_matrix(model.body_iquat[body])
        inertia = axes @ np.diag(model.body_inertia[body]) @ axes.T / mass
        at = m.position + ca.mtimes(m.rotation, centre)
        moves = ca.mtimes(m.rotation, m.velocity + ca.cross(m.omega, centre))
        place, speed = place + share * at, speed + share * moves
        spin += share * ca.cross(at, moves) + ca.mtimes([m.rotation, ca.DM(inertia), m.omega])
    return place, speed, spin
