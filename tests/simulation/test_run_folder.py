"""Outputs are refused before the work, and in the end all of them are there or none."""

import os
from pathlib import Path

import pytest

from gaitsmith.cli import plan as command
from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.simulation.run_folder import check_file, log_notes
from gaitsmith.simulation.scenario import Scenario


def test_files_that_cannot_be_written(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for name in ("pipe", "new/", "missing/file", "x" * 300):
        with pytest.raises(BadInput, match="--out"):
            check_file(f"{tmp_path}/{name}")
    with pytest.raises(BadInput, match="--out"):
        check_file("/dev/null")
    assert os.listdir(tmp_path) == ["pipe"]
    assert check_file(str(tmp_path / "new")) == tmp_path / "new"


def test_what_is_read_is_not_replaced(tmp_path: Path) -> None:
    given = tmp_path / "given"
    given.write_text("x")
    (tmp_path / "link").symlink_to(given)
    (tmp_path / "twin").hardlink_to(given)
    for name in ("given", "link", "twin", "../" + tmp_path.name + "/given"):
        with pytest.raises(BadInput, match="which is read"):
            check_file(str(tmp_path / name), [str(given)])
    check_file(str(tmp_path / "other"), [str(given), "thbip_ii"])


@pytest.mark.parametrize(
    ("broken", "error"), [("figures", KeyboardInterrupt), ("gait", KeyboardInterrupt), ("gait", OSError)]
)
def test_gait_and_figures_are_both_there_or_neither(
    broken: str, error: type[BaseException], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fails = [broken]

    def draw(gait: object, robot: object, folder: Path) -> list[Path]:
        (folder / "one.png").write_text("a figure")
        if "figures" in fails:
            raise error
        return [folder / "one.png"]

    def write(path: Path, gait: object) -> None:
        if "gait" in fails:
            raise error
        path.write_text("a gait")

    monkeypatch.setattr("gaitsmith.view.gait_figures.write_gait_figures", draw)
    monkeypatch.setattr("gaitsmith.synthesis.write_gait", write)
    out, figures = tmp_path / "gait.json", tmp_path / "new" / "figures"
    with pytest.raises(error):
        command._write(None, None, out, figures, lambda _: None)
    assert os.listdir(tmp_path) == []
    fails.clear()
    assert command._write(None, None, out, figures, lambda _: None) == [str(figures / "one.png")]
    assert sorted(os.listdir(tmp_path)) == ["gait.json", "new"]


def test_a_log_tells_where_its_robot_and_files_are_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "card").mkdir()
    notes = log_notes(Scenario(robot="card", policy="p.onnx"), load_robot("bhr_b2"), 1e-3, {})["scenario"]
    assert (notes["robot"], notes["policy"]) == (str(tmp_path / "card"), str(tmp_path / "p.onnx"))
    notes = log_notes(Scenario(robot="bhr_b2"), load_robot("bhr_b2"), 1e-3, {})["scenario"]
    assert (notes["robot"], notes["policy"]) == ("bhr_b2", "")
