"""What a plan leaves to another that is no neighbour of its: its curves, where phases have the same name."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.motions.catalogue import start
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.program.guess import default_start
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.neighbour import alike, start_from

NEAR = 0.03  # rad: a spline's control points are near its curve, not on it


def finer(motion):
    """The same motion in more sections."""
    return replace(motion, phases=tuple(replace(item, sections=item.sections + 1) for item in motion.phases))


@pytest.fixture(scope="module")
def begun(planner, static):
    """Unknowns of a motion that start from the static gait, and their meaning."""

    def made(motion):
        trans = Transcription(planner.biped, motion, Settings().sized(planner.biped, motion.transfer))
        return start_from(trans, default_start(trans), static.gait, static.main.x), trans

    return made


def at(found, border):
    """Joints (n,) at a border, from unknowns."""
    x, trans = found
    return trans.state_rows(border, 0) @ x


def test_more_sections_of_the_same_motion_begin_on_its_curves(begun, static, planner):
    motion = finer(static.gait.motion)
    assert alike(motion, motion)
    assert not alike(motion, static.gait.motion)
    found = begun(motion)
    for phase, time in enumerate(motion.borders[:-1]):
        wanted = static.gait.joints(phase, np.array([time]))[0][planner.biped.index, 0]
        assert np.abs(at(found, phase) - wanted).max() < NEAR


def test_a_start_begins_at_rest_and_ends_in_the_mirrored_step(begun, static, planner):
    biped = planner.biped
    rest = standing(biped)
    q, v, a = (values[biped.index, 0] for values in static.gait.joints(0, np.array([0.0])))
    motion = start(biped, StepParameters(0.15, 1.0), rest, (q, v, a))
    found = begun(motion)
    assert np.abs(at(found, 0) - rest).max() < 1e-9
    assert np.abs(at(found, 1) - rest).max() < NEAR
    assert np.abs(at(found, len(motion.phases)) - q).max() < NEAR


def test_loads_go_over_as_in_the_gait(begun, static):
    x, trans = begun(finer(static.gait.motion))
    loads = x[trans.wrench_columns(2)[0, 0] :]
    assert np.array_equal(loads, static.main.x[-len(loads) :])
