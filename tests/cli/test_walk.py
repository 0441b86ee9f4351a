"""Flags and files become scenarios or one line; runs end with the right code, document and folder."""

import contextlib
import io
import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitsmith.cli import main
from gaitsmith.cli.arguments import parse
from gaitsmith.cli.walk import WalkArguments, scenario_from
from gaitsmith.errors import BadInput
from gaitsmith.log import read_log
from gaitsmith.simulation import Episode, Scenario, Simulation, load_scenario
from gaitsmith.simulation.run_folder import check_new_folder, scenario_toml
from gaitsmith.simulation.scenario import make_scenario

SHORT = ["--duration", "0.3", "--rest-before", "0.1"]


def scenario_of(*words: str) -> Scenario:
    return scenario_from(parse(WalkArguments, words, "gaitsmith walk"))


def run(*words: str) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of one command line."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(words)
    return code, out.getvalue(), err.getvalue()


def test_walk_alone_is_a_short_walk() -> None:
    scenario = scenario_of()
    assert scenario.speed == (0.3, 0.0)
    assert scenario.duration == 10.0


def test_flags_become_fields() -> None:
    words = "--speed -0.2 0.1 --duration 9 --height 0.66 --period 0.3 --lift 0.08 --width 0.05 --alpha 0.4 --seed 3"
    more = "--terrain slope:4 --state estimated --joint-friction 3 --torque-delay 0.002 --friction 0.6 --preset paper"
    last = "--push 4,0,15,0 --push 5,-1,2,3 --rest-before 2 --rest-after 1"
    scenario = scenario_of(*words.split(), *more.split(), *last.split())
    assert scenario.speed == (-0.2, 0.1)
    gait = {"speed": (-0.2, 0.1), "period": 0.3, "alpha": 0.4, "height": 0.66, "lift": 0.08, "width": 0.05}
    assert scenario.given() == gait
    assert (scenario.duration, scenario.rest_before, scenario.rest_after, scenario.seed) == (9.0, 2.0, 1.0, 3)
    assert (scenario.joint_friction, scenario.torque_delay, scenario.friction) == (3.0, 0.002, 0.6)
    assert (scenario.terrain, scenario.state, scenario.preset) == ("slope:4", "estimated", "paper")
    assert [(push.time, push.impulse) for push in scenario.pushes] == [(4.0, (0.0, 15.0, 0.0)), (5.0, (-1.0, 2.0, 3.0))]


def test_flags_override_a_file(tmp_path: Path) -> None:
    path = tmp_path / "walk.toml"
    path.write_text("speed = 0.5\nduration = 30\n[[changes]]\ntime = 4\nheight = 0.6\n")
    scenario = scenario_of(str(path), "--speed", "0.2")
    assert scenario.speed == (0.2, 0.0)
    assert scenario.duration == 30.0
    assert len(scenario.changes) == 1


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["--height", "3"], "--height: got 3.0, expected 0.42 to 0.73"),
        (["--period", "-1"], "--period: got -1.0"),
        (["--period", "1000"], "--period: got 1000.0"),
        (["--speed", "nan"], "--speed: got 'nan'"),
        (["--speed", "0", "9"], "--speed: got 9.0"),
        (["--duration", "0"], "--duration: got 0.0"),
        (["--duration", "1e999"], "--duration: got"),
        (["--rest-before", "20"], "rest_before"),
        (["--push", "-1,0,15,0"], "--push time: got -1.0"),
        (["--push", "11,0,15,0"], "--push time: got 11.0"),
        (["--push", "4,0,15"], "for example --push"),
        (["--push", "4,0,nan,0"], "--push"),
        (["--push", "4,0,1e9,0"], "--push impulse"),
        (["--terrain", "stairs"], "--terrain: got 'stairs'"),
        (["--terrain", "boxes:nan"], "--terrain"),
        (["--robot", "nobody"], "--robot: got 'nobody', expected bhr_b2"),
        (["--preset", "nothing"], "--preset: got 'nothing', expected one of default, experiment, paper"),
        (["--joint-friction", "-1"], "--joint-friction"),
        (["absent.toml"], "absent.toml"),
        (["figure5", "--duration", "12"], "figure5: changes[1].time: got 13.0"),
    ],
)
def test_bad_input_is_one_line_that_names_the_field(words: list[str], part: str) -> None:
    code, out, err = run("walk", *words, "--json")
    assert code == 2
    assert len(err.splitlines()) == 1
    assert part in err
    assert part in json.loads(out)["error"]["message"]


@pytest.mark.parametrize(
    ("content", "part"),
    [
        ("", "at least one field"),
        ("duration = [", "TOML"),
        ("durashun = 3", "no such entry"),
        ("duration = nan", "duration"),
        ("duration = 9\n[[changes]]\ntime = 5\nspeed = 0.1\n[[changes]]\ntime = 4\nspeed = 0.2", "changes[1].time"),
        ("height = 5.0", "height: got 5.0"),
        ("\x00", "TOML"),
    ],
)
def test_a_bad_file_is_one_line_that_names_it(content: str, part: str, tmp_path: Path) -> None:
    path = tmp_path / "walk.toml"
    path.write_text(content)
    code, out, err = run("walk", str(path))
    assert code == 2
    assert out == ""
    assert len(err.splitlines()) == 1
    assert "walk.toml" in err
    assert part in err


def test_folders_are_refused_before_the_run(tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.mkdir()
    (tmp_path / "file").write_text("")
    for name in (str(taken), str(tmp_path / "file"), str(tmp_path / "file" / "below"), str(tmp_path / ("x" * 300))):
        code, _, err = run("walk", "--out", name, "--duration", "3600")
        assert code == 2
        assert "--out" in err
        assert len(err.splitlines()) == 1


def test_a_place_that_only_seems_writable_is_refused_before_the_run() -> None:
    if not Path("/proc/self").exists():
        pytest.skip("needs /proc")
    with pytest.raises(BadInput, match="--out"):
        check_new_folder("/proc/run")


def test_a_run_leaves_a_whole_folder_that_runs_again(tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "first"
    code, out, err = run("walk", *SHORT, "--push", "0.2,1,2,0", "--out", str(folder), "--json")
    assert code == 0
    assert err == ""
    document = json.loads(out)
    assert document["fell"] is False
    assert document["out"] == str(folder)
    assert {path.name for path in folder.parent.iterdir()} == {"first"}
    names = {path.name for path in folder.iterdir()}
    assert {"log.mcap", "summary.json", "scenario.toml", "speed.png"} <= names
    assert json.loads((folder / "summary.json").read_text())["steps"] == document["steps"]
    assert len(read_log(folder / "log.mcap").rows) > 1
    assert load_scenario(folder / "scenario.toml") == scenario_of(*SHORT, "--push", "0.2,1,2,0")


def test_tables_name_every_joint_and_stage() -> None:
    code, out, err = run("walk", *SHORT)
    assert code == 0
    assert err == ""
    for part in ("0.0 to 0.1", "rest", "left_knee", "200", "times real time", "whole-body QP"):
        assert part in out


def test_a_fall_is_explained_and_exits_with_1() -> None:
    words = ["--duration", "3", "--rest-before", "0.2", "--push", "0.3,0,400,0"]
    code, out, _ = run("walk", *words, "--json")
    assert code == 1
    document = json.loads(out)
    assert document["fell"] is True
    assert document["fall"]["time"] < 3.0
    assert document["fall"]["reason"]
    code, out, _ = run("walk", *words)
    assert code == 1
    assert "FELL at" in out


def test_ctrl_c_keeps_the_log_so_far(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    step = Simulation.step

    def interrupted(self: Simulation) -> bool:
        if self.tick == 150:
            raise KeyboardInterrupt
        return step(self)

    monkeypatch.setattr(Simulation, "step", interrupted)
    folder = tmp_path / "cut"
    code, out, err = run("walk", *SHORT, "--out", str(folder), "--no-figures", "--json")
    assert code == 130
    assert err == ""
    assert json.loads(out)["interrupted"] is True
    time = read_log(folder / "log.mcap").time
    assert 0.14 < time[-1] < 0.15
    assert len(time) == 38  # every fourth of 150 ticks


def test_ctrl_c_before_the_first_tick(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(self: Simulation, progress: Any = None) -> Episode:
        raise KeyboardInterrupt

    monkeypatch.setattr(Simulation, "run", interrupted)
    code, out, err = run("walk", *SHORT, "--out", str(tmp_path / "none"), "--json")
    assert code == 130
    assert len(err.splitlines()) == 1
    assert "error" in json.loads(out)
    assert list(tmp_path.iterdir()) == []


FLAGS = ("--speed", "--duration", "--height", "--period", "--lift", "--width", "--alpha", "--push", "--terrain")
MORE = ("--state", "--seed", "--robot", "--preset", "--joint-friction", "--torque-delay", "--rest-before", "--json")
NUMERIC = ("duration", "height", "period", "lift", "width", "alpha", "joint_friction", "torque_delay", "rest_before")
VALUES = st.one_of(
    st.floats().map(repr),
    st.integers(-5, 5).map(str),
    st.tuples(*[st.floats(-20, 20)] * 4).map(lambda numbers: ",".join(map(repr, numbers))),
    st.sampled_from(["flat", "slope:5", "slope:nan", "boxes:0.02", "true", "estimated", "default", "paper", "figure5"]),
    st.text(max_size=6),
)


@settings(max_examples=150)
@given(st.lists(st.tuples(st.sampled_from(FLAGS + MORE), VALUES), max_size=5))
def test_random_flags_are_a_scenario_or_one_line(pairs: list[tuple[str, str]]) -> None:
    words = [word for pair in pairs for word in pair]
    try:
        scenario = scenario_of(*words)
    except BadInput as error:
        assert len(str(error).splitlines()) == 1
    else:
        assert make_scenario(tomllib.loads(scenario_toml(scenario))) == scenario


NUMBERS = st.none() | st.floats(allow_nan=False, allow_infinity=False) | st.floats(0.0, 20.0)


@settings(max_examples=500)
@given(
    numbers=st.fixed_dictionaries({}, optional=dict.fromkeys(NUMERIC, NUMBERS)),
    push=st.lists(VALUES, max_size=2),
    terrain=st.none() | VALUES,
)
def test_random_values_are_a_scenario_or_one_line(
    numbers: dict[str, float | None], push: list[str], terrain: str | None
) -> None:
    words = [f"--{name.replace('_', '-')}={value!r}" for name, value in numbers.items() if value is not None]
    words += [f"--push={word}" for word in push] + ([] if terrain is None else [f"--terrain={terrain}"])
    try:
        scenario = scenario_of(*words)
    except BadInput as error:
        assert len(str(error).splitlines()) == 1
        assert error.field.startswith("--")
    else:
        assert make_scenario(tomllib.loads(scenario_toml(scenario))) == scenario


@settings(max_examples=100)
@given(st.binary(max_size=60))
def test_random_files_are_a_scenario_or_one_line(tmp_path_factory: Any, content: bytes) -> None:
    path = tmp_path_factory.mktemp("scenario") / "walk.toml"
    path.write_bytes(content)
    try:
        scenario_of(str(path))
    except BadInput as error:
        assert len(str(error).splitlines()) == 1


@given(st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=40))
def test_scenario_files_keep_every_string(name: str) -> None:
    scenario = Scenario(robot=name)
    assert make_scenario(tomllib.loads(scenario_toml(scenario))) == scenario
