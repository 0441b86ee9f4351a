"""A program's derivatives of second order: slopes of those of first order, in all kinds of phases."""

import numpy as np
import pytest
import scipy.sparse as sp

from gaitsmith.synthesis import KickParameters, Settings, StepParameters
from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.motions.catalogue import cyclic, kick
from gaitsmith.synthesis.point.caller import Caller
from gaitsmith.synthesis.program.assembly import Assembly
from gaitsmith.synthesis.program.derivatives import Derivatives
from gaitsmith.synthesis.program.program import SELDOM, ImposedBound, every_bound, make_program
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.bound_check import with_times

STEP, SLOPE = 1e-5, 1e-6  # of differences, relative
ROUNDING = 1e-12  # relative


@pytest.fixture(scope="module", params=["cyclic", "kick"])
def program(request, planner):
    biped = planner.biped
    motion = (
        cyclic(biped, StepParameters(0.15, 1.0))
        if request.param == "cyclic"
        else kick(biped, KickParameters(), standing(biped))
    )
    trans = Transcription(biped, motion, Settings(effort_weights={"right_knee": 3.0, "left_hip_yaw": 0.5}))
    return make_program(trans, planner.functions, trans.points())


def _symmetric(call, *arguments):
    call(*arguments)
    upper = call.matrix(0)
    return (upper + sp.triu(upper, 1).T).toarray()


def test_the_hessian_is_the_slope_of_the_lagrangians_gradient(program):
    rng = np.random.default_rng(4)
    assembly, derivatives, multipliers = Assembly(program), Derivatives(program), rng.normal(size=program.rows)
    x, direction = 0.1 * rng.normal(size=program.size), rng.normal(size=program.size)

    def gradient(at):
        slope, _, jacobian = derivatives.first_order(at)
        return slope + jacobian.T @ multipliers

    slope = (gradient(x + STEP * direction) - gradient(x - STEP * direction)) / (2.0 * STEP)
    found = _symmetric(Caller(assembly.hessian), x, np.zeros(0), 1.0, multipliers)
    assert np.abs(found @ direction - slope).max() < SLOPE * np.abs(slope).max()
    whole = derivatives.curvature(x, 1.0, multipliers, 0.0)
    assert np.abs(whole - found).max() < ROUNDING * np.abs(found).max()


def test_both_ways_to_the_first_derivatives_say_the_same(program):
    x = 0.1 * np.random.default_rng(5).normal(size=program.size)
    assembly, (slope, rows, jacobian) = Assembly(program), Derivatives(program).first_order(x)
    gradient, slopes = Caller(assembly.gradient), Caller(assembly.jacobian)
    gradient(x, np.zeros(0))
    slopes(x, np.zeros(0))
    pairs = [(slope, gradient.results[1]), (rows, slopes.results[0]), (jacobian.toarray(), slopes.matrix(1).toarray())]
    assert all(np.abs(a - b).max() < ROUNDING * np.abs(b).max() for a, b in pairs)


def test_the_convex_hessian_is_never_negative(program):
    x = 0.1 * np.random.default_rng(4).normal(size=program.size)
    values = np.linalg.eigvalsh(Derivatives(program).curvature(x, 0.0, 0.0, 0.0))
    assert values.max() > 0.0
    assert values.min() > -ROUNDING * values.max()


def test_points_that_only_rows_without_multipliers_look_at_bend_nothing(planner):
    trans, rng = (
        Transcription(planner.biped, cyclic(planner.biped, StepParameters(0.15, 1.0)), Settings()),
        np.random.default_rng(5),
    )
    points = trans.points()
    added = [ImposedBound(k % 2, k, float(0.29 * trans.borders[1 + k % 2])) for k in range(6)]
    imposed = every_bound(trans, points, SELDOM) + [item for item in added if item.time >= trans.borders[item.phase]]
    program = make_program(trans, planner.functions, with_times(trans, points, imposed), imposed)
    assert program.points.count > points.count
    x, multipliers = 0.1 * rng.normal(size=program.size), rng.normal(size=program.rows)
    multipliers[-len(added) - 2 :] = 0.0
    found = _symmetric(Caller(Assembly(program).hessian), x, np.zeros(0), 1.0, multipliers)
    whole = Derivatives(program).curvature(x, 1.0, multipliers, 0.0)
    assert np.abs(whole - found).max() < ROUNDING * np.abs(found).max()
    # each row says what its bound says, at its own instant
    _, o = program.evaluate(x)
    fixed, rows = program.rows - len(imposed), program.constraint(x, o)
    for row in rng.integers(fixed, program.rows, 20).tolist():
        item, label = imposed[row - fixed], program.labels[row]
        assert (label.name, label.time) == (trans.bounds[item.phase][item.bound].name, item.time)
    alone = make_program(trans, planner.functions, with_times(trans, points, imposed[-1:]), imposed[-1:])
    assert rows[-1] == pytest.approx(alone.constraint(x, alone.evaluate(x)[1])[-1], abs=1e-12)
