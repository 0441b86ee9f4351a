"""The planner's view of a robot: what can be planned for, the mirror image, and standing still."""

import subprocess
import sys
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import load_robot
from gaitsmith.synthesis.motions.biped import REST, biped_from, standing
from gaitsmith.synthesis.motions.standing import standing_joints

PLACED = 1e-8  # m
POSTURE = 1e-7  # rad: the controller's posture is balanced to 1e-9 m


def test_robots_that_cannot_be_planned_for_are_refused(robot):
    lines = load_robot("bhr_b2")
    with pytest.raises(BadInput, match="four to six"):
        biped_from(replace(lines, legs=(lines.legs[0], robot.legs[1])))
    seven = replace(robot.legs[0], joints=(*robot.legs[0].joints, "toe"))
    with pytest.raises(BadInput, match=r"7 joints.*six joints"):
        biped_from(replace(robot, legs=(seven, robot.legs[1])))


def test_mirror_is_an_involution(planner):
    values = np.random.default_rng(0).normal(size=planner.biped.joints)
    assert np.array_equal(planner.biped.mirrored(planner.biped.mirrored(values)), values)


def test_standing_still_the_weight_is_over_the_middle_of_the_soles(planner):
    biped, height = planner.biped, planner.biped.height - 0.03
    data = mujoco.MjData(biped.model)
    data.qpos[:7] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    data.qpos[7:] = standing(biped, height)
    mujoco.mj_fwdPosition(biped.model, data)
    for leg in biped.robot.legs:
        sole = data.site(leg.sole_site)
        assert np.abs(sole.xmat.reshape(3, 3) - np.eye(3)).max() < PLACED
        assert abs(biped.robot.hip_midpoint[2] - sole.xpos[2] - height) < PLACED
        assert abs(data.subtree_com[0, 0] - sole.xpos[0] - (leg.sole.toe - leg.sole.heel) / 2.0) < PLACED


def test_planning_stands_as_the_controller_does(planner):
    biped, robot = planner.biped, planner.biped.robot
    for height in (0.30, 0.34, biped.height * (1.0 - REST)):
        expected = standing_posture(robot, height, biped.width / 2.0, 0.02)[7:]
        assert np.abs(standing_joints(robot, height, biped.width / 2.0, 0.02) - expected).max() < POSTURE


def test_a_posture_out_of_reach_says_what_is_in_reach(planner):
    with pytest.raises(BadInput, match="at a width of"):
        standing_joints(planner.biped.robot, 0.6, planner.biped.width / 2.0, 0.02)


def test_planning_loads_no_compiled_kernels():
    code = "import sys, gaitsmith.synthesis.requests.request; print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "False", done.stderr
