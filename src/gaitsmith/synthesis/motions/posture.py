"""Postures by inverse kinematics: joint angles that place both soles below a torso, by MuJoCo's kinematics."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.motions.biped import Biped

Array = npt.NDArray[np.float64]
_STEPS = 60
_TOLERANCE = 1e-11


class Poser:
    """Inverse kinematics of one robot, its torso upright.

    Args:
        biped: the robot.
    """

    def __init__(self, biped: Biped) -> None:
        self.biped = biped
        self.data = mujoco.MjData(biped.model)
        self._jacobian = np.zeros((6, biped.model.nv))

    def solve(
        self, hip: Array, soles: dict[str, Array], pitches: dict[str, float], guess: Array
    ) -> tuple[Array, float]:
        """Joint angles (n,) and the largest remaining error (m or rad).

        Args:
            hip: (3,) hip midpoint, world, m.
            soles: sole frame's origin of each foot, world, m.
            pitches: pitch of each sole, rad, positive with the toe down.
            guess: (n,) angles to start from.
        """
        model, data, robot = self.biped.model, self.data, self.biped.robot
        q = guess.copy()
        error = np.inf
        data.qpos[:3] = hip - robot.hip_midpoint
        data.qpos[3:7] = (1.0, 0.0, 0.0, 0.0)
        for _ in range(_STEPS):
            data.qpos[7:] = q
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            error = 0.0
            for leg in robot.legs:
                site = model.site(leg.sole_site).id
                mujoco.mj_jacSite(model, data, self._jacobian[:3], self._jacobian[3:], site)
                c, s = np.cos(pitches[leg.name]), np.sin(pitches[leg.name])
                goal = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
                turn = goal @ data.site_xmat[site].reshape(3, 3).T
                small = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
                gap = np.concatenate([soles[leg.name] - data.site_xpos[site], small])
                error = max(error, float(np.abs(gap).max()))
                block = self._jacobian[:, 6 + leg.joint_indices]
                step = block.T @ np.linalg.solve(block @ block.T + 1e-8 * np.eye(6), gap)
                q[leg.joint_indices] += np.clip(step, -0.3, 0.3)
            if error < _TOLERANCE:
                break
        return q, error

    def centre_of_mass(self, q: Array, hip: Array) -> Array:
        """(3,) centre of mass of a posture with the torso upright, world, m."""
        self.data.qpos[:3] = hip - self.biped.robot.hip_midpoint
        self.data.qpos[3:7] = (1.0, 0.0, 0.0, 0.0)
        self.data.qpos[7:] = q
        mujoco.mj_kinematics(self.biped.model, self.data)
        mujoco.mj_comPos(self.biped.model, self.data)
        return np.array(self.data.subtree_com[0])


def bent(biped: Biped, angle: float = 0.3) -> Array:
    """Joint angles of a slight squat, from which inverse kinematics finds its way."""
    q = np.zeros(biped.joints)
    for leg in biped.robot.legs:
        q[leg.knee], q[leg.ankle_pitch] = 2.0 * angle, -angle
        pitch = leg.joint_indices[list(leg.joint_indices).index(leg.knee) - 1]
        q[pitch] = -angle
    return q


def standing(biped: Biped, height: float) -> Array:
    """q0 of eqs. (21) and (24): soles side by side, torso upright, centre of mass over the soles' middle.

    Args:
        biped: the robot.
        height: hip midpoint above the soles, m.

    Raises:
        BadInput: the legs do not reach.
    """
    poser, sole = Poser(biped), biped.leg("left").sole
    half = biped.width / 2.0
    soles = {"left": np.array([0.0, half, 0.0]), "right": np.array([0.0, -half, 0.0])}
    q, goal, hip_x = bent(biped), (sole.toe - sole.heel) / 2.0, 0.0
    for _ in range(20):
        hip = np.array([hip_x, 0.0, height])
        q, error = poser.solve(hip, soles, {"left": 0.0, "right": 0.0}, q)
        if error > 1e-6:
            raise BadInput("height", height, f"less than {biped.height:.3g} m, hip to sole with straight legs")
        gap = goal - float(poser.centre_of_mass(q, hip)[0])
        hip_x += gap
        if abs(gap) < 1e-10:
            break
    return q
