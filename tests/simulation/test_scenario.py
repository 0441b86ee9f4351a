"""Scenarios: what is valid is kept, what is not is refused in one line that names the field."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.simulation.standing import robot

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.simulation.scenario import GAIT_INPUTS, Scenario, check_scenario, load_scenario, make_scenario

MANY = settings(max_examples=1000)
anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)
fields = st.dictionaries(
    st.sampled_from([*Scenario.model_fields, "unknown"]) | st.text(max_size=6), anything, max_size=5
)


def _refusal(given_fields) -> str:
    with pytest.raises(BadInput) as caught:
        make_scenario(given_fields, "run.toml")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600
    return str(caught.value)


@MANY
@given(fields)
def test_whatever_is_given_becomes_a_scenario_or_one_line(data):
    try:
        scenario = make_scenario(data)
    except BadInput as error:
        assert "\n" not in str(error)
        return
    assert scenario.rest_before + scenario.rest_after <= scenario.duration
    assert all(math.isfinite(n) for n in scenario.region().x + scenario.region().y)


@MANY
@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_whatever_is_in_a_file_is_refused_in_one_line(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "random.toml"
    path.write_bytes(content)
    try:
        load_scenario(path)
    except BadInput as error:
        assert "\n" not in str(error)
        assert "random.toml" in str(error)


@settings(max_examples=300)
@given(st.lists(st.floats(0.0, 19.0), min_size=2, max_size=5, unique=True))
def test_times_must_rise(times):
    changes = [{"time": time, "lift": 0.1} for time in times]
    if times == sorted(times):
        assert [change.time for change in make_scenario({"changes": changes}).changes] == times
    else:
        assert "changes[" in _refusal({"changes": changes})


@MANY
@given(
    st.sampled_from([name for name in GAIT_INPUTS if name != "speed"]), st.floats(allow_nan=True, allow_infinity=True)
)
def test_gait_inputs_outside_the_robot_s_limits_are_refused(name, value):
    low, high = getattr(robot().card.gait_limits, name)
    try:
        check_scenario(make_scenario({name: value}), robot())
    except BadInput as error:
        assert not low <= value <= high
        assert error.field.endswith(name)
        return
    assert low <= value <= high


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"duration": math.nan}, "run.toml: duration: got nan, expected a finite number"),
        (
            {"duration": 1e12},
            "run.toml: duration: got 1000000000000.0, expected a finite number above 0 up to 1000000000",
        ),
        ({"speeed": 1}, "run.toml: speeed: got 1, expected no such entry; this table takes only speed"),
        (
            {"changes": [{"time": 1.0, "foo": 2}]},
            "changes[0].foo: got 2, expected no such entry; this table takes only speed",
        ),
        ({"changes": [{"time": 1.0}]}, "a time and at least one of speed"),
        (
            {"changes": [{"time": 30.0, "lift": 0.1}]},
            "changes[0].time: got 30.0, expected less than the duration, 20 s",
        ),
        (
            {"pushes": [{"time": -1.0, "impulse": [1, 0, 0]}]},
            "pushes[0].time: got -1.0, expected a finite number from 0",
        ),
        ({"pushes": [{"time": 21.0, "impulse": [1, 0, 0]}]}, "pushes[0].time: got 21.0, expected 0 s to less than"),
        ({"pushes": [{"time": 2.0, "impulse": [1, math.inf, 0]}]}, "pushes[0].impulse[1]"),
        ({"pushes": [{"impulse": [1, 0, 0]}]}, "pushes[0].time: got nothing, expected a finite number"),
        (
            {"pushes": [{"time": 1.0, "impulse": [1, 0, 0], "body": "torso", "joint": "left_knee"}]},
            "joint: got 'left_knee', expected nothing beside a body",
        ),
        ({"controller": "socket:0"}, "controller: got 'socket:0', expected socket:PORT, the port from 1 to 65535"),
        ({"speed": [0.1, 0.2, 0.3]}, "speed: got [0.1, 0.2, 0.3], expected one or two finite numbers, m/s"),
        ({"speed": "fast"}, "speed: got 'fast', expected one or two finite numbers"),
        ({"state": "guessed"}, "state: got 'guessed', expected one of true, estimated"),
        ({"terrain": "boxes:9"}, "terrain: got 'boxes:9', expected boxes:METRES, 0 to 0.3"),
        (
            {"rest_before": 15.0, "rest_after": 6.0},
            "duration: got 20.0, expected at least rest_before + rest_after = 21 s",
        ),
        ({"seed": True}, "seed: got True"),
        ({"seed": -1}, "seed: got -1"),
    ],
)
def test_refusals_name_field_value_and_what_is_valid(data, told):
    assert told in _refusal(data)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "an empty file"),
        (b"# nothing\n", "an empty file"),
        (b"duration = ", "a scenario in TOML"),
        (b"\xff\xfe", "a scenario in TOML"),
        (b"a = 1\n" * 200_000, "at most 1000000 bytes"),
    ],
)
def test_files_that_hold_no_scenario(tmp_path, content, told):
    path = tmp_path / "s.toml"
    path.write_bytes(content)
    with pytest.raises(BadInput, match=told):
        load_scenario(path)


def test_a_missing_file_names_the_shipped_scenarios(tmp_path):
    with pytest.raises(BadInput, match="figure5"):
        load_scenario(tmp_path / "none.toml")


def test_figure5_is_the_paper_s_profile():
    scenario = load_scenario("figure5")
    check_scenario(scenario, robot())
    speeds = [0.0, *(change.speed[0] for change in scenario.changes)]
    assert speeds == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0])
    assert [change.time for change in scenario.changes] == [9.0 + 4.0 * k for k in range(14)]
    assert (scenario.walk_from, scenario.walk_until, scenario.duration) == (5.0, 65.0, 70.0)


def test_one_number_is_a_forward_speed():
    assert make_scenario({"speed": 0.3}).speed == (0.3, 0.0)
    assert make_scenario({"speed": [0.3]}).speed == (0.3, 0.0)
    assert make_scenario({"speed": [0.3, -0.1]}).speed == (0.3, -0.1)


def test_the_region_holds_the_commanded_path():
    changes = [{"time": 11.0, "speed": [-0.5, 0.2]}]
    region = make_scenario({"speed": [0.4, 0.0], "changes": changes, "duration": 31.0}).region()
    assert region.x[0] < 4.0 - 10.0
    assert region.x[1] > 4.0
    assert region.y[1] > 4.0


def test_the_region_holds_a_circle_however_often_it_is_walked():
    region = make_scenario({"speed": 0.3, "yaw_rate": 0.1, "duration": 200.0}).region()  # a circle of 3 m about (0, 3)
    assert region.x == pytest.approx((-6.0, 6.0), abs=0.1)
    assert region.y == pytest.approx((-1.5, 7.5), abs=0.1)


def test_the_region_turns_with_the_robot():
    """A quarter turn in place, then 5 m ahead: to the left of where it began."""
    changes = [{"time": 11.0, "yaw_rate": 0.0, "speed": [0.5, 0.0]}]
    region = make_scenario({"yaw_rate": math.pi / 20.0, "changes": changes, "duration": 21.0}).region()
    assert region.x == pytest.approx((-3.0, 3.0))
    assert region.y == pytest.approx((-1.5, 6.5))


def test_a_robot_that_cannot_turn_says_so():
    for fields, field in (
        ({"yaw_rate": 0.3}, "yaw_rate"),
        ({"changes": [{"time": 2.0, "yaw_rate": 0.3}]}, "changes[0].yaw_rate"),
    ):
        with pytest.raises(BadInput) as caught:
            check_scenario(make_scenario(fields), robot())
        assert str(caught.value) == f"{field}: got 0.3, expected 0 only; the legs cannot turn"
    check_scenario(make_scenario({"yaw_rate": 0.0}), robot())


def test_a_posture_is_checked_against_the_robot():
    robot = load_robot(Path(__file__).parents[1] / "models/with_arms.toml")
    for posture, told in (({"left_knee": 0.1}, "outside the legs"), ({"left_elbow": 0.5}, "-2.5 to 0 rad")):
        scenario = make_scenario({"changes": [{"time": 1.0, "posture": posture}]})
        with pytest.raises(BadInput, match=told) as caught:
            check_scenario(scenario, robot)
        assert caught.value.field.startswith("changes[0].posture")
    scenario = make_scenario({"changes": [{"time": 1.0, "posture": {"left_elbow": -0.5}}]})
    check_scenario(scenario, robot)
    assert len({scenario, make_scenario(scenario.model_dump(mode="json", exclude_defaults=True))}) == 1


def test_an_unknown_preset_names_the_known_ones():
    with pytest.raises(BadInput, match="preset: got 'best', expected one of"):
        check_scenario(Scenario(preset="best"), robot())


@pytest.mark.parametrize("value", [0.0, math.inf])
def test_a_number_out_of_range_is_told_its_bound(value):
    assert _refusal({"duration": value}).endswith("expected a finite number above 0 up to 1000000000")


def test_the_bound_is_told_below_the_top_too():
    assert _refusal({"changes": [{"time": -1.0, "speed": 0.1}]}).endswith("expected a finite number from 0")


def test_what_is_missing_or_nested_too_deeply_is_told_in_our_own_words():
    assert _refusal({"pushes": [{"time": 1.0, "impulse": [0, 1]}]}).endswith(
        "impulse[2]: got nothing, expected a finite number from -1000 to 1000"
    )
    nested: list[object] = []
    for _ in range(300):
        nested = [nested]
    assert "nested deeply" in _refusal({"robot": nested})
