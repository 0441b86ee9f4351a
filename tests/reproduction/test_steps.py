"""Steps measured on short runs of which they are known."""

from itertools import pairwise

import numpy as np
import pytest

from gaitsmith.reports.run import Run, make_run
from gaitsmith.reproduction.steps import settled, steps_of
from gaitsmith.reproduction.template import _alike
from gaitsmith.simulation.scenario import Change, Scenario


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Four seconds at 0.2 m/s, then with a shorter period."""
    scenario = Scenario(duration=7.0, rest_before=0.2, speed=(0.2, 0.0), changes=(Change(time=4.0, period=0.3),))
    return make_run(scenario, tmp_path_factory.mktemp("runs") / "walk", lambda time: None)


def test_steps_are_as_long_as_speed_times_duration(walk: Run) -> None:
    steps = settled(steps_of(walk))
    for period in (0.4, 0.3):
        own = [step for step in steps if step.period == pytest.approx(period)]
        assert len(own) >= 3
        mean = float(np.mean([step.length for step in own]))
        assert mean == pytest.approx(0.2 * float(np.mean([step.duration for step in own])), abs=0.01)
    assert all(step.raised == pytest.approx(step.lift, rel=0.03) for step in steps)
    assert all(step.hip == pytest.approx(step.height, abs=5e-3) for step in steps)


def test_sides_alternate_and_a_change_starts_the_count_anew(walk: Run) -> None:
    steps = steps_of(walk)
    assert all(a.side != b.side for a, b in pairwise(steps))
    change = next(k for k, step in enumerate(steps) if step.period < 0.35)
    assert steps[change].since == 0
    assert steps[change - 1].since > 4


def test_a_periodic_curve_is_itself_a_period_later_and_noise_is_not() -> None:
    phase = np.arange(2000) / 100.0
    assert _alike(np.sin(2.0 * np.pi * phase), 100) == pytest.approx(1.0)
    assert _alike(np.random.default_rng(0).standard_normal(2000), 100) < 0.2
