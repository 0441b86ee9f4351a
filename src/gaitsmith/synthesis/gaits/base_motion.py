"""Motion of the base from the joints' for many instants at once, while one sole stands still."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]


def _cross(a: Array, b: Array) -> Array:
    """(N, 3) cross products, without the checks of NumPy's own."""
    ax, ay, az, bx, by, bz = (*np.moveaxis(a, -1, 0), *np.moveaxis(b, -1, 0))
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _quaternion(axis: Array, angle: Array) -> Array:
    """(N, 4) quaternions w x y z of turns about one axis."""
    half = 0.5 * angle[:, None]
    return np.concatenate([np.cos(half), np.sin(half) * axis], axis=1)


def _product(a: Array, b: Array) -> Array:
    """(N, 4) products of quaternions."""
    w, v = a[..., :1], a[..., 1:]
    scalar = w * b[..., :1] - np.sum(v * b[..., 1:], axis=-1, keepdims=True)
    return np.concatenate([scalar, w * b[..., 1:] + b[..., :1] * v + _cross(v, b[..., 1:])], axis=-1)


def _turned(q: Array, v: Array) -> Array:
    """(N, 3) vectors turned by quaternions."""
    twice = 2.0 * _cross(q[..., 1:], v)
    return np.asarray(v + q[..., :1] * twice + _cross(q[..., 1:], twice))


class BaseMotion:
    """Full states of a robot one of whose soles lies flat and still, axes along the world's.

    The same as :class:`gaitsmith.synthesis.gaits.full_state.StateFinder` gives one by one, for a whole array.

    Args:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._chains = {leg.name: self._chain(robot.model, leg.sole_site) for leg in robot.legs}

    @staticmethod
    def _chain(model: Any, site: str) -> tuple[list[int], int]:
        """Bodies from below the base down to a sole's, and the sole's site."""
        number = int(model.site(site).id)
        body, path = int(model.site_bodyid[number]), []
        while int(model.body_parentid[body]) != 0:
            path.append(body)
            body = int(model.body_parentid[body])
        return path[::-1], number

    def states(self, support: str, footholds: Array, q: Array, v: Array, a: Array) -> tuple[Array, Array, Array]:
        """Positions (N, nq), velocities and accelerations (N, nv) in MuJoCo's order and axes.

        Args:
            support: left or right.
            footholds: (N, 2) x and y of the sole frame, world, m.
            q, v, a: (n, N) joint angles, velocities and accelerations.
        """
        model = self.robot.model
        path, site = self._chains[support]
        count = q.shape[1]
        turn, place = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
        speed, pull, omega, alpha = (np.zeros((count, 3)) for _ in range(4))

        def move(arm: Array) -> None:
            """To a point that is fixed in the present body, ``arm`` away, base axes."""
            nonlocal place, speed, pull
            spin = _cross(omega, arm)
            place, speed = place + arm, speed + spin
            pull = pull + _cross(alpha, arm) + _cross(omega, spin)

        for body in path:
            move(_turned(turn, model.body_pos[body]))
            turn = _product(turn, model.body_quat[body])
            first = int(model.body_jntadr[body])
            for joint in range(first, first + int(model.body_jntnum[body])):
                address, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
                angle, rate, change = q[address - 7] - model.qpos0[address], v[dof - 6, :, None], a[dof - 6, :, None]
                axis = _turned(turn, model.jnt_axis[joint])
                if int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE):
                    move(angle[:, None] * axis)
                    speed = speed + rate * axis
                    pull = pull + change * axis + 2.0 * rate * _cross(omega, axis)
                    continue
                move(_turned(turn, model.jnt_pos[joint]))
                turn = _product(turn, _quaternion(model.jnt_axis[joint], angle))
                alpha = alpha + change * axis + rate * _cross(omega, axis)
                omega = omega + rate * axis
                move(-_turned(turn, model.jnt_pos[joint]))
        move(_turned(turn, model.site_pos[site]))
        turn = _product(turn, model.site_quat[site])
        return self._inverted((turn, place, speed, pull, omega, alpha), footholds, (q, v, a))

    def _inverted(
        self, sole: tuple[Array, ...], footholds: Array, joints: tuple[Array, Array, Array]
    ) -> tuple[Array, Array, Array]:
        """The base's motion in the world from the sole's in the base."""
        model = self.robot.model
        turn, place, speed, pull, omega, alpha = sole
        count = len(turn)
        back = turn * np.array([1.0, -1.0, -1.0, -1.0])
        back /= np.linalg.norm(back, axis=1, keepdims=True)
        back *= np.where(back[:, :1] < 0.0, -1.0, 1.0)
        position, velocity, acceleration = (
            np.zeros((count, model.nq)),
            np.zeros((count, model.nv)),
            np.zeros((count, model.nv)),
        )
        spin = _cross(-omega, place)
        position[:, :2] = footholds
        position[:, :3] -= _turned(back, place)
        position[:, 3:7] = back
        velocity[:, :3] = -_turned(back, spin + speed)
        velocity[:, 3:6] = -omega
        carried = _cross(-alpha, place) + _cross(-omega, spin) + 2.0 * _cross(-omega, speed)
        acceleration[:, :3] = -_turned(back, carried + pull)
        acceleration[:, 3:6] = -alpha
        position[:, 7:], velocity[:, 6:], acceleration[:, 6:] = (values.T for values in joints)
        return position, velocity, acceleration
