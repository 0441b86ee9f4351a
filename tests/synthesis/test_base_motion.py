"""The base's motion for many instants at once is that of MuJoCo's kinematics, one by one."""

from copy import copy
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from gaitsmith.synthesis.gaits.base_motion import BaseMotion
from gaitsmith.synthesis.gaits.full_state import StateFinder

SAME = 1e-11  # accelerations are of the order of 100
PLACE = (0.3, -0.1)


@pytest.mark.parametrize("support", ["left", "right"])
@pytest.mark.parametrize("slide", [False, True])
def test_equal_to_mujocos(robot, support, slide):
    if slide:
        model = copy(robot.model)
        for leg in robot.legs:
            model.jnt_type[leg.joint_indices[1] + 1] = mujoco.mjtJoint.mjJNT_SLIDE
        robot = replace(robot, model=model)
    rng = np.random.default_rng(0)
    q, v, a = (rng.normal(size=(len(robot.joint_names), 20)) * size for size in (0.4, 2.0, 20.0))
    found = BaseMotion(robot).states(support, np.tile(PLACE, (20, 1)), q, v, a)
    finder = StateFinder(robot)
    for k in range(20):
        state = finder.find(support, PLACE, q[:, k], v[:, k], a[:, k])
        turn = state.position[3:7] * np.sign(state.position[3:7] @ found.position[k, 3:7])
        wanted = np.concatenate([state.position[:3], turn, state.position[7:], state.velocity, state.acceleration])
        given = np.concatenate([part[k] for part in (found.position, found.velocity, found.acceleration)])
        assert np.abs(given - wanted).max() < SAME
        assert np.abs(found.com[k] - finder.centre_of_mass()).max() < SAME
