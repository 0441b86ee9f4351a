"""Walks by a library: on the way from rest to a speed, from speed to speed and back, pushed, the robot stands."""

import json
import re
import shutil

import numpy as np
import pytest
from tests.library.conftest import GRID, PAGE

from gaitsmith.__main__ import main
from gaitsmith.errors import BadInput
from gaitsmith.simulation import Simulation, library_run, run_episode
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.stage_table import stride_lines


def scenario(library, **fields):
    base = {"library": str(library.path), "robot": "thbip_ii", "speed": [0.25, 0.0]}
    return make_scenario({**base, **fields})


def test_it_starts_changes_speed_and_period_survives_pushes_stops_and_starts_again(library):
    changes = [
        {"time": 7.0, "speed": [0.3, 0.0], "period": 0.65},
        {"time": 12.0, "speed": [0.0, 0.0]},
        {"time": 18.0, "speed": [0.2, 0.0]},
    ]
    pushes = [{"time": 5.3, "impulse": [0.0, 2.0, 0.0]}, {"time": 10.1, "impulse": [-2.0, 0.0, 0.0]}]
    summary = run_episode(scenario(library, duration=26.0, changes=changes, pushes=pushes), record=False).summary
    assert summary.fall is None
    speeds = [stage.vx_mean for stage in summary.stages]
    assert speeds[1] == pytest.approx(0.25, rel=0.05)
    assert speeds[2] == pytest.approx(0.3, rel=0.05)
    assert speeds[4] == pytest.approx(0.2, rel=0.1)
    assert summary.tracking is None


def test_between_the_points_of_the_grid_the_speed_is_the_one_commanded(library):
    simulation = Simulation(scenario(library, speed=[0.23, 0.0], duration=14.0), record=False)
    clock, first = simulation.controller.plan_clock, simulation.plan.table.loop_first
    found, before = [], -1
    while simulation.step():
        clock = simulation.controller.plan_clock
        if clock.visit[0] == first != before:
            found.append((simulation.time, simulation.plant.com[0]))
        before = int(clock.visit[0])
    (begin, x), (end, far) = found[-5], found[-1]
    assert (far - x) / (end - begin) == pytest.approx(0.23, rel=0.005)


def test_at_rest_it_stays_where_it_is(library):
    simulation = Simulation(scenario(library, speed=[0.0, 0.0], duration=3.0), record=False)
    began = simulation.plant.q.copy()
    while simulation.step():
        pass
    assert np.abs(simulation.plant.q - began).max() < 0.01


@pytest.mark.parametrize(
    ("fields", "field", "valid"),
    [
        ({"speed": [0.5, 0.0]}, "speed", "0.2 to 0.3"),
        ({"speed": [0.25, 0.1]}, "speed", "sideways"),
        ({"period": 0.3}, "period", "0.6 to 0.7"),
        ({"yaw_rate": 0.1}, "yaw_rate", "axes of the library"),
        ({"changes": [{"time": 3.0, "speed": [0.9, 0.0]}]}, r"changes\[0\].speed", "0.2 to 0.3"),
    ],
)
def test_what_the_library_does_not_hold_is_refused(library, family, fields, field, valid, monkeypatch):
    monkeypatch.setattr(library_run, "Family", lambda *given: family)
    with pytest.raises(BadInput, match=field) as error:
        Simulation(scenario(library, **fields), record=False)
    assert valid in str(error.value)


@pytest.mark.parametrize("fields", [{"gait": ["x.json"]}, {"policy": "x.onnx"}, {"cycles": 3}])
def test_a_library_leaves_no_room_for_other_gaits(library, fields):
    with pytest.raises(BadInput):
        scenario(library, **fields)


def test_what_the_page_tells_to_type_works(library, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(library.path, "library")
    (tmp_path / "grid.toml").write_text(GRID)
    lines = [line for block in re.findall(r"```sh\n(.*?)```", PAGE, re.S) for line in block.splitlines()]
    documents = []
    for line in lines:
        assert main([*line.split()[1:], "--json"]) == 0, line
        documents.append(json.loads(capsys.readouterr().out))
    assert documents[0]["resumed"] == 4
    assert (tmp_path / "library.png").exists()
    walked = documents[2]
    assert (walked["fell"], walked["steps_held"]) == (False, 0)
    assert [stage["rest"] for stage in walked["stages"]][1:] == [False, True]
    assert walked["stages"][1]["vx_mean"] == pytest.approx(0.3, rel=0.002)


def test_steps_that_cannot_change_are_counted_and_told(library):
    simulation = Simulation(scenario(library, duration=5.0, changes=[{"time": 3.0, "speed": [0.3, 0.0]}]), record=False)
    weights = simulation._family.weights

    def hole(inputs):
        if 0.25 < inputs["speed"] < 0.3:
            raise BadInput("speed", inputs["speed"], "a gait that could be planned")
        return weights(inputs)

    simulation._family.weights = hole
    summary = simulation.run().summary
    assert summary.steps_held > 0
    assert f"{summary.steps_held} steps stayed as they were" in "\n".join(stride_lines(summary))


def test_the_commands_say_what_they_made_and_what_there_is(library, tmp_path, capsys):
    spec = tmp_path / "grid.toml"
    spec.write_text(GRID)
    assert main(["library", "build", str(spec), "--out", str(library.path), "--json"]) == 0
    made = json.loads(capsys.readouterr().out)
    assert {"gaits": 4, "certified": 4, "failed": [], "resumed": 4}.items() <= made.items()
    assert main(["library", "show", str(library.path), "--figure", str(tmp_path / "grid.png"), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert [point["status"] for point in shown["points"]] == ["certified"] * 4
    assert (tmp_path / "grid.png").stat().st_size > 5_000
    assert "period, s" in (tmp_path / "grid.svg").read_text()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["library", "build", "no.toml", "--out", "x"], "no.toml"),
        (["library", "show", "nowhere"], "nowhere"),
        (["walk", "--library", "nowhere", "--speed", "0.2"], "nowhere"),
        (["library", "build", "GRID", "--out", "x", "--engine", "ray"], "--address"),
        (["library", "build", "GRID", "--out", "x", "--engine", "ray", "--address", "127.0.0.1:1"], "--address"),
        (["library", "build", "GRID", "--out", "x", "--engine", "ray", "--address", "here"], "--address"),
    ],
)
def test_what_cannot_be_is_one_line(words, told, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "grid.toml").write_text('robot = "thbip_ii"\nspeed = [0.2]\n')
    assert main(["grid.toml" if word == "GRID" else word for word in words]) == 2
    error = capsys.readouterr().err.strip()
    assert told in error or "ray" in error
    assert "\n" not in error
    assert not (tmp_path / "x").exists()
