"""A robot that cannot walk the paper's gaits is no bad input: the claims stay open, and the reason is told."""

import json
from types import SimpleNamespace

import pytest

from gaitsmith.cli import main


def test_an_unsolved_gait_is_not_solved(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    failed = SimpleNamespace(gait=None, main=SimpleNamespace(status="not solved", reason="legs too weak"))
    planner = SimpleNamespace(biped=SimpleNamespace(lines=False))
    monkeypatch.setattr("gaitsmith.synthesis.Planner", lambda robot, notify: planner)
    monkeypatch.setattr("gaitsmith.synthesis.answer", lambda planner, request, report: failed)
    assert main(["plan", "--claims", "--json"]) == 3
    captured = capsys.readouterr()
    assert captured.err.count("legs too weak") == 1
    document = json.loads(captured.out)
    assert document["status"] == "not solved"
    assert "legs too weak" in document["reason"]
