"""A gait at any instants of any number of its steps, without being written out step by step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import CHANNELS, Gait, follow, unrolled
from gaitsmith.synthesis.gaits.support import zmp
from gaitsmith.synthesis.motions.biped import biped_from
from gaitsmith.synthesis.motions.motion import Phase, about_vertical

Array = npt.NDArray[np.float64]
LONGEST = 3600.0  # s, of all steps together


@dataclass(frozen=True, eq=False)
class Samples:
    """A gait at N instants; MuJoCo's order and axes.

    Attributes:
        phases: the phase of every instant.
        position: (N, nq) base position and quaternion w x y z, joint angles.
        velocity: (N, nv).
        acceleration: (N, nv).
        com: (N, 3) centre of mass, world, m.
        torque: (N, n) N·m.
        wrench: (N, 12) left force and moment, right force and moment, world axes, about the sole frames' origins.
        zmp: (N, 2) world, m.
    """

    phases: list[Phase]
    position: Array
    velocity: Array
    acceleration: Array
    com: Array
    torque: Array
    wrench: Array
    zmp: Array


class UnrolledGait:
    """A gait, a cyclic one repeated: two steps are written out, and all others are these two further on.

    Args:
        gait: the gait.
        robot: the robot that it was planned for.
        steps: of a cyclic gait, in strides if it is one; others are gone through once.

    Attributes:
        duration: of all steps, s.

    Raises:
        BadInput: steps that take more than an hour in all.
    """

    def __init__(self, gait: Gait, robot: Robot, steps: int) -> None:
        biped = biped_from(robot)
        once = gait.motion.steps if gait.motion.cyclic else 1
        self.steps = max(steps // once, 1) if gait.motion.cyclic else 1
        self.duration = self.steps * gait.duration
        if self.duration > LONGEST:
            valid = f"1 to {once * int(LONGEST / gait.duration)}, an hour in all at {gait.duration / once:.4g} s a step"
            raise BadInput("--steps", steps, valid)
        self._finder = StateFinder(robot)
        self._pair = unrolled(gait, biped.partner, biped.sign, min(self.steps, 2))
        self._first = np.array(gait.motion.phases[0].foothold)
        self._starts, self._turn = self._first[None], 0.0  # of every pair of steps: where its first sole stands
        if self.steps > 2:
            second = follow(gait, gait, gait.motion.mirrored, biped.partner, biped.sign)
            third = follow(second, gait, False, biped.partner, biped.sign).motion.phases[0]
            self._turn = third.heading - gait.motion.phases[0].heading
            way = third.foothold - self._first
            ways = [about_vertical(k * self._turn)[:2, :2] @ way for k in range((self.steps - 1) // 2)]
            self._starts = np.cumsum([self._first, *ways], axis=0)

    def at(self, times: Array) -> Samples:
        """The gait at times (N,) from 0 to its duration, s."""
        pair, joints = self._pair, len(self._pair.joint_names)
        turns = np.clip(np.floor(times / pair.duration), 0, (self.steps - 1) // 2).astype(np.int64)
        within = times - turns * pair.duration
        borders = pair.motion.borders
        index = np.clip(np.searchsorted(borders, within, side="right") - 1, 0, len(borders) - 2)
        model, count = self._finder.model, len(times)
        widths = (model.nq, model.nv, model.nv, 3, joints, CHANNELS, 2)
        found = Samples(
            [pair.motion.phases[number] for number in index.tolist()], *(np.zeros((count, w)) for w in widths)
        )
        for number in np.unique(index).tolist():
            phase, mask = pair.motion.phases[number], np.flatnonzero(index == number)
            q, v, a = (values.T for values in pair.joints(number, within[mask]))
            root = pair.roots(number, within[mask]).T
            wrenches = pair.wrenches(number, within[mask])
            with np.errstate(divide="ignore", invalid="ignore"):  # without load there is no ZMP
                found.zmp[mask] = zmp(phase, wrenches, root.T[0, :3] if phase.tips else None).T
            for k, row in enumerate(mask.tolist()):
                heading = turns[row] * self._turn
                away, start = about_vertical(heading)[:2, :2], self._starts[turns[row]]
                x, y = start + away @ (phase.foothold - self._first)
                found.zmp[row] = start + away @ (found.zmp[row] - self._first)
                heading += phase.heading
                state = self._finder.find(phase.support, (x, y), q[k], v[k], a[k], root[k].T, heading)
                found.position[row], found.velocity[row] = state.position, state.velocity
                found.acceleration[row], found.com[row] = state.acceleration, self._finder.centre_of_mass()
                found.wrench[row] = (wrenches[:, k].reshape(4, 3) @ about_vertical(heading).T).ravel()
            found.torque[mask] = pair.torques(number, within[mask]).T
        return found
