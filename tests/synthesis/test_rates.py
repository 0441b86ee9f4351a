"""Torque rates: measured on polynomials, kept within their bound in planned gaits, at little cost."""

from itertools import pairwise

import numpy as np
import pytest

from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.program.rates import rate_form, steepest
from gaitsmith.synthesis.program.smoothness import torque_rates
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.requests.summary import largest_torque_rate
from gaitsmith.synthesis.solution.rate_check import Rates, with_fast

FREE = {"static": 114.2, "dynamic": 61.7}  # J without bound and weights
DEARER = 1.05


@pytest.fixture(scope="module")
def trans(planner):
    settings = Settings().sized(planner.biped, 0.3)
    return Transcription(planner.biped, cyclic(planner.biped, StepParameters(0.15, 1.0)), settings)


def _torques(trans, points, values):
    o = np.zeros((points.count, trans.layout.outputs))
    o[:, trans.layout.torque + 3] = values
    return o.ravel()


def test_the_rate_of_a_polynomial_is_its_derivative(trans):
    points = trans.points()
    o = _torques(trans, points, points.time**3 - 2.0 * points.time)
    for phase in range(len(trans.motion.phases)):
        time = float(trans.borders[phase] + 0.37 * trans.motion.phases[phase].duration)
        keys, weights = rate_form(trans, phase, time)
        places = [points.places()[key] * trans.layout.outputs + trans.layout.torque + 3 for key in keys]
        assert weights @ o[places] == pytest.approx(3.0 * time**2 - 2.0)


def test_the_weighed_rates_are_the_integral_of_their_square(trans):
    points = trans.points()
    rates = torque_rates(trans, points) @ _torques(trans, points, points.time**2)
    assert rates @ rates == pytest.approx(4.0 / 3.0 * trans.borders[-1] ** 3)


@pytest.mark.parametrize(("name", "most"), [("static", 200.0), ("dynamic", 600.0)])
def test_the_papers_gaits_keep_their_torque_rates_at_little_cost(name, most, request):
    found = request.getfixturevalue(name)
    assert largest_torque_rate(found.gait) <= most
    assert found.main.objective <= DEARER * FREE[name]


def test_a_rate_beyond_its_bound_is_imposed_with_those_that_nearly_reach_it(trans):
    all_times = [np.linspace(a, b, 40) for a, b in pairwise(trans.borders)]
    rates = [Rates(times, np.zeros((trans.biped.joints, 40))) for times in all_times]
    times, values, most = all_times[0], rates[0].values, steepest(trans, 0)
    values[3] = most * (1.1 - 4.0 * (np.linspace(0.0, 1.0, 40) - 0.4) ** 2)
    values[5] = 0.99 * most
    found = with_fast(trans, rates, [])
    assert {(item.phase, item.bound - len(trans.bounds[0])) for item in found} == {(0, 3)}
    assert len(found) > 1
    assert min(np.interp([item.time for item in found], times, values[3])) > 0.89 * most
