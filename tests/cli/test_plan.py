"""Commands plan, verify, export, and walk with a gait file: exit codes, documents, one line when something is wrong."""

import json

import pytest

from gaitsmith.cli import main

PLAN_KEYS = {
    *("status", "motion", "objective", "iterations", "time_s", "variables", "constraints", "max_torque"),
    *("zmp_margin_mm", "worst", "file"),
}
VERIFY_KEYS = {
    *("ok", "worst", "closure", "torque_jump", "dynamics_residual", "penetration_mm", "clearance_mm"),
    *("zmp_margin_mm",),
}


@pytest.fixture(scope="module")
def gait(tmp_path_factory):
    path = tmp_path_factory.mktemp("plan") / "gait.json"
    assert main(["plan", "cyclic", "--speed", "0.4", "--out", str(path), "--json"]) == 0
    return path


def _document(capsys):
    return json.loads(capsys.readouterr().out)


def test_plan_prints_its_document(tmp_path, capsys):
    path = tmp_path / "gait.json"
    assert main(["plan", "cyclic", "--step-length", "0.2", "--period", "0.5", "--out", str(path), "--json"]) == 0
    document = _document(capsys)
    assert set(document) >= PLAN_KEYS
    assert document["status"] == "solved"
    assert set(document["time_s"]) >= {"setup", "compile", "solve"}
    assert set(document["worst"][0]) >= {"constraint", "value", "limit", "time", "phase"}
    assert document["file"] == str(path)


def test_figures_that_cannot_be_drawn_cost_nothing_but_themselves(tmp_path, capsys, monkeypatch):
    def broken(*_):
        raise ValueError("no such glyph")

    monkeypatch.setattr("gaitsmith.view.gait_figures.write_gait_figures", broken)
    words = ["plan", "cyclic", "--speed", "0.4", "--out", str(tmp_path / "g.json"), "--figures", str(tmp_path / "f")]
    assert main([*words, "--json"]) == 0
    captured = capsys.readouterr()
    assert captured.err.splitlines()[-1].endswith("no figures: ValueError: no such glyph")
    assert json.loads(captured.out)["figures"] == []
    assert [path.name for path in tmp_path.iterdir()] == ["g.json"]


def test_verify_agrees(gait, capsys):
    assert main(["verify", str(gait), "--json"]) == 0
    document = _document(capsys)
    assert set(document) >= VERIFY_KEYS
    assert document["ok"] is True


def test_verify_of_an_edited_file_fails(gait, tmp_path, capsys):
    content = json.loads(gait.read_text())
    content["phases"][1]["sections"][0]["torque"][2][0] += 0.5
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(content))
    assert main(["verify", str(bad), "--json"]) == 1
    assert _document(capsys)["ok"] is False
    assert main(["walk", "--gait", str(bad)]) == 2
    assert "edited" in capsys.readouterr().err


def test_walk_and_export(gait, tmp_path, capsys):
    assert (
        main(["walk", "--gait", str(gait), "--cycles", "4", "--json", "--out", str(tmp_path / "run"), "--no-figures"])
        == 0
    )
    document = _document(capsys)
    assert document["fell"] is False
    tracking = document["tracking"]
    assert tracking["ended"] is True
    assert tracking["distance"] == pytest.approx(tracking["planned_distance"], rel=0.03)
    assert tracking["ball"] is None
    assert set(tracking["foot_pitch_deg"]) == {"strike", "off", "planned_strike", "planned_off"}
    assert main(["walk", str(tmp_path / "run" / "scenario.toml"), "--duration", "1", "--json"]) == 0
    assert _document(capsys)["duration"] == pytest.approx(1.0)
    out = tmp_path / "rows.csv"
    assert main(["export", str(gait), "--rate", "200", "--out", str(out), "--json"]) == 0
    assert _document(capsys)["rows"] == len(out.read_text().splitlines()) - 1


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--speed", "0.2"], "--speed"),
        (["--rest-after", "1"], "--rest-after"),
        (["--cycles", "0"], "--cycles"),
        (["--robot", "bhr_b2"], "--robot"),
        (["--tracking", "other"], "--tracking"),
    ],
)
def test_what_a_planned_walk_cannot_do_is_one_line(gait, words, told, capsys):
    assert main(["walk", "--gait", str(gait), *words]) == 2
    error = capsys.readouterr().err.strip()
    assert error.startswith(f"gaitsmith: {told}")
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["plan", "nowhere.toml"], 2),
        (["plan", "cyclic", "--speed", "nan"], 2),
        (["plan", "cyclic", "--speed", "0.4", "--step-length", "0.3", "--period", "0.5"], 2),
        (["plan", "cyclic", "--order", "6"], 2),
        (["plan", "kick", "--robot", "bhr_b2"], 2),
        (["plan", "cyclic", "--out", "/nowhere/gait.json"], 2),
        (["plan", "kick", "--period", "1"], 2),
        (["plan", "cyclic", "--angle", "5"], 2),
        (["plan", "turn", "--angle", "0"], 2),
        (["plan", "turn", "--steps", "4"], 2),
        (["plan", "turn", "--step-length", "0.001"], 2),
        (["plan", "cyclic", "--step-length", "0.8", "--period", "1.0"], 3),
        (["verify", "nowhere.json"], 2),
        (["verify", "nowhere.json", "--dense", "1000000000"], 2),
        (["plan", "cyclic", "--out", "/dev/null"], 2),
        (["plan", "--claims", "--robot", "bhr_b2"], 2),
        (["export", "nowhere.json"], 2),
        (["walk", "--gait", "nowhere.json"], 2),
        (["walk", "--cycles", "3"], 2),
        (["walk", "--tracking", "replay"], 2),
    ],
)
def test_what_is_wrong_is_one_line(words, code, capsys):
    assert main(words) == code
    error = capsys.readouterr().err.strip()
    assert error.startswith("gaitsmith: ")
    assert len(error.splitlines()) == 1


def test_an_unsolved_plan_leaves_no_file(tmp_path, capsys):
    path = tmp_path / "gait.json"
    words = [
        "plan",
        "cyclic",
        "--step-length",
        "0.8",
        "--period",
        "1.0",
        "--out",
        str(path),
        "--json",
    ]
    assert main(words) == 3
    document = _document(capsys)
    assert document["status"] == "not solved"
    assert document["reason"]
    assert not path.exists()


def test_an_export_keeps_the_whole_name_and_never_the_gait(gait, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    named = tmp_path / "walk v0.40"
    named.write_bytes(gait.read_bytes())
    assert main(["export", named.name, "--rate", "50", "--json"]) == 0
    assert _document(capsys)["file"] == str(tmp_path / "walk v0.40.csv")
    assert main(["export", named.name, "--rate", "50", "--out", named.name]) == 2
    assert named.read_bytes() == gait.read_bytes()


def test_a_refusal_of_the_planner_names_the_flag(capsys):
    assert main(["plan", "cyclic", "--zmp-margin", "0.9"]) == 2
    assert "--zmp-margin: got 0.9" in capsys.readouterr().err


@pytest.mark.parametrize("rate", ["0", "-5", "inf"])
def test_rates(gait, rate, capsys):
    assert main(["export", str(gait), "--rate", rate]) == 2
    assert "--rate" in capsys.readouterr().err
