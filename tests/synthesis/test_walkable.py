"""A gait file as a plan: the file's joints and torques, MuJoCo's kinematics, sections that join, steps that mirror."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.planned.evaluate import evaluate, make_plan_sample
from gaitsmith.planned.table import ENDLESS, PER_SOLE, SOLES, TORSO
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.synthesis.motions.biped import biped_from

AXES = 3


@pytest.fixture(scope="module")
def gait(dynamic):
    return dynamic.gait


@pytest.fixture(scope="module")
def plan(gait, robot):
    return walkable([gait], robot)


def at(plan, time):
    """Section and sample at a time within the loop."""
    table = plan.table
    starts = np.concatenate([[0.0], np.cumsum(table.duration[table.sequence])])
    visit = min(int(np.searchsorted(starts, time, side="right")) - 1, len(table.sequence) - 1)
    sample = make_plan_sample(2, table.motion.shape[2] - SOLES - 2 * PER_SOLE)
    section = int(table.sequence[visit])
    evaluate(table, section, time - starts[visit], sample)
    return section, sample.motion.copy(), sample.effort.copy()


@pytest.mark.parametrize("time", [0.0, 0.09, 0.31, 0.37, 0.43, 0.49])
def test_curves_are_those_of_the_file_and_of_the_model(gait, robot, plan, time):
    section, motion, effort = at(plan, time)
    number = int(np.searchsorted(gait.motion.borders, time, side="right")) - 1
    phase, instant = gait.motion.phases[number], np.array([time])
    q, v, a = (values[:, 0] for values in gait.joints(number, instant))
    joints = SOLES + 2 * PER_SOLE
    for order, values in enumerate((q, v, a)):
        np.testing.assert_allclose(motion[order, joints:], values, atol=1e-8 * 10.0 ** (2 * order))
    np.testing.assert_allclose(effort[: len(q)], gait.torques(number, instant)[:, 0], atol=1e-3)
    np.testing.assert_allclose(effort[len(q) :], gait.wrenches(number, instant)[:, 0], atol=1e-2)
    finder = StateFinder(robot)
    finder.find(phase.support, (0.0, 0.0), q, v, a)
    assert robot.legs[plan.table.support[section]].name == phase.support
    np.testing.assert_allclose(motion[0, :AXES], finder.centre_of_mass(), atol=1e-9)
    mujoco.mj_subtreeVel(robot.model, finder.data)
    np.testing.assert_allclose(motion[1, :AXES], finder.data.subtree_linvel[0], atol=1e-6)
    for row, leg in enumerate(robot.legs):
        place, speed, pull, rotation, _, _ = finder.foot(leg.name, np.zeros(3))
        first = SOLES + PER_SOLE * row
        for order, (values, slack) in enumerate(((place, 1e-9), (speed, 1e-6), (pull, 1e-3))):
            np.testing.assert_allclose(motion[order, first : first + AXES], values, atol=slack)
        assert motion[0, first + AXES + 1] == pytest.approx(np.arcsin(-rotation[2, 0]), abs=1e-8)


def test_tracked_quantities_are_continuous_where_sections_meet(plan):
    """Across a change of the support sole, after the move to the new one."""
    table = plan.table
    times = np.cumsum(table.duration[table.sequence])[:-1]
    for time in times:
        (one, before, _), (two, after, _) = at(plan, time - 1e-9), at(plan, time + 1e-9)
        moved = table.place[one, table.support[two], :3]
        assert np.abs(before[0, :AXES] - after[0, :AXES] - moved).max() < 1e-7
        assert np.abs(before[1, : SOLES + 2 * PER_SOLE] - after[1, : SOLES + 2 * PER_SOLE]).max() < 1e-4
        assert np.abs(before[0, TORSO:SOLES] - after[0, TORSO:SOLES]).max() < 1e-7


def test_the_second_step_is_the_mirror_image_of_the_first(robot, plan):
    biped, step = biped_from(robot), 0.5
    joints = SOLES + 2 * PER_SOLE
    for time in (0.1, 0.36, 0.47):
        _, first, _ = at(plan, time)
        _, second, _ = at(plan, time + step)
        np.testing.assert_allclose(second[0, :AXES], first[0, :AXES] * (1.0, -1.0, 1.0), atol=1e-8)
        np.testing.assert_allclose(second[0, joints:], biped.mirrored(first[0, joints:]), atol=1e-8)


def test_weights_add_up_and_join_from_stretch_to_stretch(plan):
    table = plan.table
    np.testing.assert_allclose(table.weight_from.sum(axis=1), 1.0)
    ends = np.flatnonzero(np.isclose(table.stretch_start + table.duration, table.stretch_duration))
    for k in ends[:-1]:
        np.testing.assert_array_equal(table.weight_to[k], table.weight_from[k + 1])


def test_cycles_are_counted_and_repeated_steps_are_kept_once(gait, robot, plan):
    assert plan.table.passes == ENDLESS
    assert plan.duration == np.inf
    odd = walkable([gait], robot, 5)
    assert odd.duration == pytest.approx(5 * gait.duration)
    assert len(odd.table.duration) < 1.5 * len(plan.table.duration)  # the last double support leads nowhere
    assert odd.speed == pytest.approx(0.4)
    assert odd.way(odd.duration).x == pytest.approx(5 * 0.2, abs=1e-6)


def test_the_planned_way_is_a_stride_for_every_stride(gait, robot, plan):
    stride = 2.0 * gait.duration
    ways = [plan.way(time).x for time in (0.0, 0.3, stride, 7.0 * stride, 7.0 * stride + 0.3)]
    assert ways[0] == 0.0
    assert 0.0 < ways[1] < ways[2]
    np.testing.assert_allclose(ways[2:4], [0.4, 2.8], atol=1e-9)
    assert ways[4] == pytest.approx(ways[3] + ways[1], abs=1e-9)


def test_what_does_not_belong_together_is_refused(gait, robot):
    with pytest.raises(BadInput, match=r"--robot: .* the robot that the gait was planned for"):
        walkable([replace(gait, robot_hash="0" * 64)], robot)
    with pytest.raises(BadInput, match=r"--gait: .* one at most"):
        walkable([gait, gait], robot)
    with pytest.raises(BadInput, match="--cycles"):
        walkable([gait], robot, 0)
    still = replace(gait, motion=replace(gait.motion, cyclic=False))
    with pytest.raises(BadInput, match="--cycles"):
        walkable([still], robot, 3)
    bent = replace(gait.pieces[0][0], joints=gait.pieces[0][0].joints + 0.1)
    other = replace(still, pieces=((bent,), *gait.pieces[1:]))
    with pytest.raises(BadInput, match=r"--gait: .* begins in the posture"):
        walkable([gait, other], robot, 2)
