"""Figures are chosen by name, what fails costs only itself, and the page shows every row with its verdict."""

import json
from pathlib import Path

import pytest
from tests.cli.test_walk import run

from gaitsmith.errors import BadInput
from gaitsmith.reproduction import reproducing
from gaitsmith.reproduction.finding import Found
from gaitsmith.reproduction.reproducing import EXPERIMENTS, FIGURES, Experiment, chosen, reproduce
from gaitsmith.view.canvas import figure

PAPERS = {"template": range(5, 12), "synthesis": range(4, 13)}


def _good(found: Found, tell: object) -> None:
    with figure("a line", 2.0) as made:
        made.subplots().plot([0, 1])
    found.draw("template5", made)
    found.say("template5", "it walks", "1 m", True)
    found.say("template6", "it flies", "0 m", False, "it does not")
    found.say("template6", "it sings", "-", None, "no ears")


def _bad(found: Found, tell: object) -> None:
    raise ZeroDivisionError("no step")


def _stopped(found: Found, tell: object) -> None:
    raise KeyboardInterrupt


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> dict[str, Experiment]:
    """Experiments that take no time."""
    table = {"good": Experiment(("template5", "template6"), _good), "bad": Experiment(("synthesis4",), _bad)}
    monkeypatch.setattr(reproducing, "EXPERIMENTS", table)
    return table


def test_every_figure_of_both_papers_has_one_experiment_and_the_profile_three() -> None:
    """In each engine, and as printed."""
    assert [f"{paper}{number}" for paper, numbers in PAPERS.items() for number in numbers] == list(FIGURES)
    made = [figure for experiment in EXPERIMENTS.values() for figure in experiment.figures]
    assert sorted(made) == sorted([*FIGURES, "template5", "template5"])


def test_figures_are_chosen_by_name_or_paper_in_their_order() -> None:
    assert chosen(()) == FIGURES
    assert chosen(("synthesis5", "template10", "synthesis5")) == ("template10", "synthesis5")
    assert chosen(("synthesis",)) == tuple(name for name in FIGURES if name.startswith("synthesis"))
    with pytest.raises(BadInput, match="template4"):
        chosen(("template4",))


def test_a_figure_that_fails_costs_only_itself(made_up: dict[str, Experiment], tmp_path: Path) -> None:
    heard: list[tuple[int, int, str]] = []
    found = reproduce(("template5", "template6", "synthesis4"), tmp_path, 1, lambda *told: heard.append(told))
    assert [row.verdict.split(":")[0] for row in found.rows] == ["agrees", "differs", "cannot be compared"]
    assert "no step" in found.failed["bad"]
    assert heard[-1][:2] == (2, 2)
    text = found.page.read_text()
    for words in ("3 statements: 1 agree, 1 differ, 1 cannot", "gaitsmith reproduce template6", "no step", "it sings"):
        assert words in text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "template5.png", "template5.svg"]


def test_what_was_finished_before_an_interruption_is_shown(made_up: dict[str, Experiment], tmp_path: Path) -> None:
    made_up["bad"] = Experiment(("synthesis4",), _stopped)
    found = reproduce(("template5", "synthesis4"), tmp_path, 1, lambda *told: None)
    assert found.interrupted
    assert [row.figure for row in found.rows] == ["template5"]
    assert "Interrupted" in found.page.read_text()


def test_the_command_tells_of_failures_and_of_a_figure_that_is_none(
    made_up: dict[str, Experiment], tmp_path: Path
) -> None:
    code, out, _ = run("reproduce", "template5", "template6", "--out", str(tmp_path / "a"), "--json")
    assert code == 0
    assert len(json.loads(out)["rows"]) == 3
    assert run("reproduce", "synthesis4", "--out", str(tmp_path / "b"))[0] == 3
    code, _, said = run("reproduce", "template99", "--out", str(tmp_path / "c"))
    assert code == 2
    assert "FIGURE" in said
    assert not (tmp_path / "c").exists()
