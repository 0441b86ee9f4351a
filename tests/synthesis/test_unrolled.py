"""A gait repeated is the gait written out step by step."""

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.gaits.gait import unrolled
from gaitsmith.synthesis.gaits.unrolled import LONGEST, UnrolledGait

SAME = 1e-6  # rad, m, N or N·m: where steps meet, curves agree to this


@pytest.mark.parametrize("steps", [1, 2, 5])
def test_equal_to_the_steps_written_out(dynamic, robot, planner, steps):
    whole = unrolled(dynamic.gait, planner.biped.partner, planner.biped.sign, steps)
    repeated = UnrolledGait(dynamic.gait, robot, steps)
    assert np.isclose(repeated.duration, whole.duration)
    times, borders = np.linspace(0.0, whole.duration, 97), whole.motion.borders
    found = repeated.at(times)
    for k, time in enumerate(times):
        phase = int(np.clip(np.searchsorted(borders, time, side="right") - 1, 0, len(borders) - 2))
        instant = np.array([time])
        assert np.abs(found.position[k, 7:] - whole.joints(phase, instant)[0][:, 0]).max() < SAME
        assert np.abs(found.torque[k] - whole.torques(phase, instant)[:, 0]).max() < SAME
        assert np.abs(found.wrench[k] - whole.wrenches(phase, instant)[:, 0]).max() < SAME
    assert np.abs(np.diff(found.position[:, 0])).max() < 2.0 * whole.duration / 96


def test_an_hour_is_the_most(dynamic, robot):
    most = int(LONGEST / dynamic.gait.duration)
    assert UnrolledGait(dynamic.gait, robot, most).duration <= LONGEST
    with pytest.raises(BadInput, match=f"--steps.*{most}"):
        UnrolledGait(dynamic.gait, robot, most + 1)
