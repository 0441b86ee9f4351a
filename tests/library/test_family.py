"""Gaits mixed: at a point of the grid they are its gait, between the points nothing jumps."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.library.family import Family
from gaitsmith.planned.evaluate import evaluate, make_plan_sample
from gaitsmith.planned.table import COM, PER_SOLE, SOLES, TORSO
from gaitsmith.robots import load_robot
from gaitsmith.synthesis.gaits.walkable import walkable

POINTS = [(0, 0, 0), (1, 0, 0), (0, 0, 1), (1, 0, 1)]


def sampled(table, section, time):
    sample = make_plan_sample(2, table.motion.shape[2] - SOLES - 2 * PER_SOLE)
    evaluate(table, section, time, sample)
    return sample.motion.copy(), sample.effort.copy()


def moved(motion, by):
    """The same motion relative to a support sole elsewhere (x, y, z, heading)."""
    found = motion.copy()
    cos, sin = np.cos(by[3]), np.sin(by[3])
    for first in (COM, SOLES, SOLES + PER_SOLE):
        found[0, first : first + 3] -= by[:3]
        x, y = found[:, first].copy(), found[:, first + 1].copy()
        found[:, first], found[:, first + 1] = cos * x + sin * y, cos * y - sin * x
    found[0, [TORSO, SOLES + 3, SOLES + PER_SOLE + 3]] -= by[3]
    return found


def seams(table, whole=False):
    """Largest jumps of places, rates and accelerations from visit to visit of the loop, or of all."""
    visits = [*(range(len(table.sequence)) if whole else range(table.loop_first, table.loop_end))]
    worst = np.zeros(3)
    for one, two in itertools.pairwise(table.sequence[visits]):
        before, _ = sampled(table, one, table.duration[one])
        after, _ = sampled(table, two, 0.0)
        before = moved(before, table.place[one, table.support[two]] - table.place[one, table.support[one]])
        worst = np.maximum(worst, np.abs(after - before).max(axis=1))
    return worst


@pytest.mark.parametrize("point", POINTS)
def test_at_a_point_of_the_grid_the_mix_is_its_gait(family, library, point):
    robot = load_robot("thbip_ii")
    weights = family.weights(family.coordinates(point))
    assert weights == {point: 1.0}
    for half in (0, 1):
        family.write(half, weights, weights)
    gait = library.gait("-".join(f"{k:03d}" for k in point), library.whole()[1]["-".join(f"{k:03d}" for k in point)])
    own = walkable([gait], robot).table
    table, whole = family.plan.table, float(own.duration[own.sequence].sum())
    assert float(table.duration[table.loop_first : table.loop_end].sum()) == pytest.approx(whole, abs=1e-9)

    def at(plan, first, end, time):
        for visit in range(first, end):
            section = plan.sequence[visit]
            if time < plan.duration[section] or visit == end - 1:
                return sampled(plan, section, time)
            time -= plan.duration[section]
        raise AssertionError

    for time in np.linspace(0.01, whole - 0.01, 23):
        mine, effort = at(table, table.loop_first, table.loop_end, time)
        theirs, force = at(own, 0, len(own.sequence), time)
        assert np.abs(mine[0] - theirs[0]).max() < 1e-7
        assert np.abs(mine[1] - theirs[1]).max() < 1e-5
        assert np.abs(effort - force).max() < 0.05


@pytest.mark.parametrize(("before", "after"), [((0.2, 0.6), (0.3, 0.7)), ((0.25, 0.62), (0.21, 0.69))])
def test_from_step_to_step_nothing_jumps(family, before, after):
    first, second = (family.weights({"speed": v, "period": t}) for v, t in (before, after))
    family.write(0, first, first)
    family.write(1, first, first)
    steady = seams(family.plan.table)
    family.write(1, first, second)
    family.plan.table.place[family.plan.table.loop_first]
    changing = seams(family.plan.table)
    assert changing[0] < steady[0] + 1e-6
    assert changing[1] < steady[1] + 1e-3
    half = [np.flatnonzero(family.stretch == number) for number in family.loop[2:]]
    lengths = [family.plan.table.stretch_duration[rows[0]] for rows in half]
    swings = [sum(w * family._curves(p)[2].span for p, w in mix.items()) for mix in (first, second)]
    assert lengths[0] == pytest.approx(0.5 * sum(swings))


def test_weights_are_multilinear_and_sum_to_one(family):
    for speed, period in itertools.product(np.linspace(0.2, 0.3, 7), np.linspace(0.6, 0.7, 5)):
        found = family.weights({"speed": float(speed), "period": float(period)})
        assert sum(found.values()) == pytest.approx(1.0)
        mean = {name: sum(w * family.coordinates(p)[name] for p, w in found.items()) for name in ("speed", "period")}
        assert mean == pytest.approx({"speed": speed, "period": period})


def test_outside_of_the_grid_the_error_says_what_it_holds(family):
    with pytest.raises(BadInput, match=r"speed.*0\.2 to 0\.3"):
        family.weights({"speed": 0.4, "period": 0.65})


def test_an_axis_of_one_value_holds_that_value_alone():
    spec = SimpleNamespace(names=("speed", "period"), axes=((0.15,), (1.0,)))
    one = SimpleNamespace(spec=spec, certified=lambda point: True)
    assert Family.weights(one, {"speed": 0.15, "period": 1.0}) == {(0, 0): 1.0}
    for inputs, valid in (
        ({"speed": 0.2}, "speed: .* 0.15, what"),
        ({"speed": 0.15, "period": 0.9}, "period: .* 1, what"),
    ):
        with pytest.raises(BadInput, match=valid):
            Family.weights(one, inputs)


def test_beside_a_gait_that_could_not_be_planned_there_is_no_mix(family, monkeypatch):
    monkeypatch.setattr(family, "certified", lambda point: point != (1, 0, 1))
    assert family.weights({"speed": 0.25, "period": 0.6})
    with pytest.raises(BadInput, match="could be planned"):
        family.weights({"speed": 0.25, "period": 0.65})
