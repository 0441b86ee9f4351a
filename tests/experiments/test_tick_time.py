"""The tick's own promises, and the report about it; times are not judged here, machines differ."""

from __future__ import annotations

import pytest
from tests.simulation.standing import robot

from gaitsmith.documents import checked
from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.experiments import TickOptions, measure_tick
from gaitsmith.experiments.tick_time import count_allocations
from gaitsmith.simulation import Simulation
from gaitsmith.simulation.scenario import make_scenario


def test_ten_thousand_ticks_allocate_nothing():
    scenario = make_scenario({"duration": 11.0, "speed": 0.2, "changes": [{"time": 6.0, "speed": 0.4}]})
    assert count_allocations(Simulation(scenario, robot=robot())) == 0


def test_too_short_a_run_counts_nothing():
    with pytest.raises(GaitsmithError, match="before"):
        count_allocations(Simulation(make_scenario({"duration": 0.5, "rest_before": 0.5}), robot=robot()), ticks=600)


def test_the_report_is_whole():
    told = []
    result = measure_tick(TickOptions(duration=5.0), progress=lambda *what: told.append(what[:2]))
    assert told == [(k, 4) for k in range(5)]
    assert not result.interrupted
    when = {(row["when"], row["quantity"]) for row in result.document["findings"]}
    assert {("walking", "tick_median"), ("walking, pushed", "qp_fallbacks"), ("walking", "realtime_factor")} <= when
    assert all(len(row) == len(result.columns) for row in result.rows)


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"duration": 1.0}, "duration"),
        ({"duration": float("nan")}, "duration"),
        ({"preset": "none"}, "preset"),
    ],
)
def test_options_that_cannot_be_used_are_named(options, field):
    with pytest.raises(BadInput) as caught:
        measure_tick(checked(TickOptions, options))
    assert caught.value.field.removeprefix("--") == field
