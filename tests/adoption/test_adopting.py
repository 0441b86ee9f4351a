"""A folder is written whole, by a robot that was tested, or not at all; what cannot be inferred is asked."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.adoption.made_up import MadeUp

from gaitsmith.adoption import adopting
from gaitsmith.adoption.options import AdoptOptions
from gaitsmith.cli import main
from gaitsmith.documents import toml
from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot

KEYS = {"card", "robot", "legs", "inferred", "assumed", "asked", "notes", "tests", "search", "sheet", "advice"}


def written(folder: Path, made: MadeUp) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / "walker.xml"
    path.write_text(made.text())
    return path


@pytest.mark.parametrize(
    "made",
    [
        MadeUp(sole="trapezoid", waist=1, turned=3.0, reversed_joints=("roll",)),
        MadeUp(hip=("roll", "pitch"), ankle=("pitch",), sole="line", floating=False),
    ],
)
def test_a_made_up_biped_is_adopted_and_walks(tmp_path: Path, made: MadeUp, capsys: pytest.CaptureFixture[str]) -> None:
    model, out = written(tmp_path / "in", made), tmp_path / "out"
    code = main(["adopt", str(model), "--out", str(out), "--no-sheet", "--json"])
    document = json.loads(capsys.readouterr().out)
    assert set(document) == KEYS
    assert (code, [test["ok"] for test in document["tests"].values()]) == (0, [True] * 3), document["tests"]
    assert sorted(path.name for path in out.iterdir()) == ["card.toml", "robot.png", "robot.svg", "walker.xml"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in", "out"]
    robot = load_robot(out)
    assert [list(leg.joints) for leg in robot.legs] == [leg["joints"] for leg in document["legs"]]
    card = (out / "card.toml").read_text().splitlines()
    assert len([line for line in card if line and not line.startswith("#")]) <= 40
    assert all("  # " in line for line in card if line.startswith(("torso", "joints", "sole")))
    assert {"torso", "legs[0].sole"} <= {entry["entry"] for entry in document["inferred"]}
    assert {"velocity"} <= {entry["entry"].rpartition(".")[2] for entry in document["assumed"]}


def test_soles_are_asked_for_with_a_candidate_that_can_be_given(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, out = written(tmp_path / "in", MadeUp(sole="none")), tmp_path / "out"
    assert main(["adopt", str(model), "--out", str(out), "--json"]) == 2
    asked = json.loads(capsys.readouterr().out)["asked"]
    assert [entry["flag"] for entry in asked] == ["--sole"]
    assert all(float(word) > 0.0 for word in asked[0]["candidates"][0].split())
    assert not out.exists()
    words = ["adopt", str(model), "--out", str(out), "--json", "--no-sheet", "--sole", "0.06", "0.12", "0.04", "0.05"]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["tests"]["soles"]["ok"]
    assert load_robot(out).legs[0].sole.kind == "rectangle"


def test_what_is_no_biped_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, out = written(tmp_path / "in", MadeUp(sides=(1,))), tmp_path / "out"
    assert main(["adopt", str(model), "--out", str(out)]) == 2
    assert "two legs" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


@pytest.mark.parametrize(
    ("made", "flags", "flag", "candidates"),
    [
        (MadeUp(extra_legs=1), [], "--feet", {"l_ankle1", "r_ankle1", "l4_ankle1", "r4_ankle1"}),
        (MadeUp(), ["--feet", "l_ankle1", "--feet", "none"], "--feet", {"l_ankle1", "r_ankle1"}),
        (MadeUp(), ["--torso", "l_shank"], "--torso", {"pelvis", "chest"}),
        (MadeUp(sole="none"), [], "--sole", {"0.042 0.133 0.035 0.063"}),
    ],
)
def test_what_cannot_be_inferred_is_asked_with_candidates(
    made: MadeUp, flags: list[str], flag: str, candidates: set[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = written(tmp_path / "in", made)
    assert main(["adopt", str(model), "--out", str(tmp_path / "out"), "--json", *flags]) == 2
    told = capsys.readouterr()
    document = json.loads(told.out)
    (asked,) = document["asked"]
    assert told.err == f"gaitsmith: {document['error']['message']}\n"
    assert asked["flag"] == flag
    assert candidates <= set(asked["candidates"])
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


def test_a_failure_half_way_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(adopting, "examine", fails)
    model = written(tmp_path / "in", MadeUp())
    with pytest.raises(KeyboardInterrupt):
        adopting.adopt(AdoptOptions(model=str(model), out=str(tmp_path / "out")))
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


def test_a_folder_that_is_there_is_not_touched(tmp_path: Path) -> None:
    model = written(tmp_path / "in", MadeUp())
    with pytest.raises(BadInput, match="--out"):
        adopting.adopt(AdoptOptions(model=str(model), out=str(tmp_path / "in")))


def test_a_refusal_leaves_no_folder(tmp_path: Path) -> None:
    (tmp_path / "block.xml").write_text('<mujoco><worldbody><geom size=".1"/></worldbody></mujoco>')
    with pytest.raises(BadInput):
        adopting.adopt(AdoptOptions(model=str(tmp_path / "block.xml"), out=str(tmp_path / "new" / "robot")))
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("given", ["nothing.xml", "no_such_robot", "a\x00b", "", "in"])
def test_no_model(given: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "in").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match="MODEL"):
        adopting.adopt(AdoptOptions(model=given))


@pytest.mark.parametrize("value", ['a "quoted" name', [1, 2.5, -0.0], {"rpy": [0.0, 1e-7, 3.0]}, True, "ü\x7f\t"])
def test_values_are_written_as_they_are_read(value: object) -> None:
    import tomllib

    assert tomllib.loads(f"x = {toml(value)}")["x"] == value
