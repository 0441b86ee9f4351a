"""The robot commands say what the card says, and refuse what cannot be loaded in one line."""

import json
import shutil
from pathlib import Path

import pytest

from gaitsmith.cli import main
from gaitsmith.robots import load_robot, robot_names

CARD = load_robot("bhr_b2").model_path.parent


def test_list_names_every_shipped_robot(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["robots"]
    assert tuple(entry["name"] for entry in listed) == robot_names()
    assert main(["robots", "list"]) == 0
    assert all(name in capsys.readouterr().out for name in robot_names()[:1])


def test_show_gives_what_a_program_needs(capsys: pytest.CaptureFixture[str]) -> None:
    robot = load_robot("bhr_b2")
    assert main(["robots", "show", "bhr_b2", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["joints"] == list(robot.joint_names)
    assert shown["mass"] == pytest.approx(robot.mass)
    assert Path(shown["model_path"]).is_file()
    assert set(shown["limits"]) == set(robot.joint_names)
    assert {leg["name"] for leg in shown["legs"]} == {"left", "right"}
    for leg in shown["legs"]:
        assert leg["sole"]["heel"] > 0.0
        assert leg["sole"]["toe"] > 0.0
        assert leg["sole"]["half_width"] >= 0.0
    assert shown["assumptions"]


def test_show_prints_every_joint_and_assumption(capsys: pytest.CaptureFixture[str]) -> None:
    robot = load_robot("bhr_b2")
    assert main(["robots", "show", "bhr_b2"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in robot.joint_names)
    assert shown.count("assumed:") == len(robot.card.assumptions)


def test_check_lets_it_stand(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "check", str(CARD), "--json"]) == 0
    checked = json.loads(capsys.readouterr().out)
    assert checked["ok"] is True
    assert set(checked["standing"]) == set(checked["joints"])
    assert [test["ok"] for test in checked["tests"].values()] == [True] * 3
    assert main(["robots", "check", "bhr_b2", "--no-tests"]) == 0
    assert "card and model fit" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("before", "after", "part"),
    [
        ("mass = 39.898", "mass = -1.0", "mass"),
        ('knee = "left_knee"', 'knee = "left_elbow"', "left_elbow"),
        ('model = "bhr_b2.xml"', 'model = "../bhr_b2.xml"', "model"),
        ("height = 0.70", "height = 3.0", "height"),
        ("schema_version = 2", "schema_version = 99", "schema_version"),
    ],
)
def test_a_bad_card_is_one_line(
    before: str, after: str, part: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "robot"
    shutil.copytree(CARD, folder)
    card = folder / "card.toml"
    text = card.read_text()
    assert before in text
    card.write_text(text.replace(before, after, 1))
    for command in ("check", "show"):
        assert main(["robots", command, str(folder)]) == 2
        captured = capsys.readouterr()
        assert captured.out == ""
        assert len(captured.err.splitlines()) == 1
        assert part in captured.err


def test_an_unknown_robot_is_refused_with_the_names(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "show", "nobody", "--json"]) == 2
    captured = capsys.readouterr()
    assert json.loads(captured.out)["error"]["field"] == "ROBOT"
    assert "bhr_b2" in captured.err
    assert "gaitsmith robots list" in captured.err


def test_an_old_card_is_used_with_a_note(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "robot"
    shutil.copytree(CARD, folder)
    card = folder / "card.toml"
    card.write_text(card.read_text().replace("schema_version = 2", "schema_version = 1", 1))
    assert main(["robots", "check", str(folder), "--no-tests"]) == 0
    captured = capsys.readouterr()
    assert "schema_version 1" in captured.out
    assert captured.err.count("presets") == 1
