"""A gait file and its robot are found together, or what does not fit is named as the user wrote it."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gaitsmith.cli import log_convert, show
from gaitsmith.cli.export import export
from gaitsmith.cli.inputs import named_robot, planned_gait, require_ending
from gaitsmith.errors import BadInput
from gaitsmith.simulation.run_folder import LOG, SCENARIO, SUMMARY


def gait_of(robot: str, cyclic: bool) -> Any:
    motion = SimpleNamespace(name="kick", cyclic=cyclic)
    return SimpleNamespace(robot=robot, robot_hash="0" * 64, joint_names=(), motion=motion)


def test_steps_are_for_cyclic_gaits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read = lambda path, robot: (gait_of("thbip_ii", False), None, True)  # noqa: E731
    monkeypatch.setattr("gaitsmith.cli.export.planned_gait", read)
    with pytest.raises(BadInput, match="--steps: got 3, expected nothing for kick"):
        export(["gait.json", "--steps", "3", "--out", str(tmp_path / "gait.csv")], "gaitsmith export")


def test_an_unknown_robot_is_named_by_its_flag() -> None:
    with pytest.raises(BadInput, match="--robot: got 'nobody'"):
        named_robot("nobody")


@pytest.mark.parametrize(
    ("planned", "given", "parts"),
    [
        ("somebody", None, ["--robot: got nothing", "somebody"]),
        ("thbip_ii", "bhr_b2", ["--robot: got 'bhr_b2'", "thbip_ii"]),
    ],
)
def test_another_robot_is_refused(
    planned: str, given: str | None, parts: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    read = lambda path, allow_edited: (gait_of(planned, True), True)  # noqa: E731
    monkeypatch.setattr("gaitsmith.synthesis.files.gait_file.read_gait", read)
    with pytest.raises(BadInput) as caught:
        planned_gait("gait.json", given)
    assert all(part in str(caught.value) for part in parts)
    assert given is None or "give --robot" not in str(caught.value)


def test_a_file_is_not_named_as_another_format_s() -> None:
    endings = {"csv": ".csv", "npz": ".npz"}
    for out in (None, "run.csv", "run.txt", "run"):
        require_ending(out, "--to", "csv", endings)
    with pytest.raises(BadInput, match=r"--out: got 'run.NPZ', .* give --to npz"):
        require_ending("run.NPZ", "--to", "csv", endings)


@pytest.mark.parametrize("name", [LOG, SUMMARY, SCENARIO])
def test_a_run_that_is_read_is_not_replaced(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gaitsmith.reports.run.open_run", lambda path: SimpleNamespace(folder=Path(path)))
    (tmp_path / name).write_text("a run")
    for command in (show.report, log_convert.convert):
        with pytest.raises(BadInput, match=r"--out: .* which is read"):
            command([str(tmp_path), "--out", str(tmp_path / name)], "gaitsmith")
    assert (tmp_path / name).read_text() == "a run"
