"""What comes from a file cannot command the terminal, and a number that does not exist is a dash."""

import io
import sys

import pytest
from rich.table import Table as RichTable

from gaitsmith.cli.dispatch import Table
from gaitsmith.cli.plan_report import figure
from gaitsmith.cli.printing import Printer, print_rich

NASTY = "\x1b]0;title\x07\x1b[2J phase\u202e\x9b31m"


def test_control_characters_are_shown_not_obeyed(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = io.StringIO()
    monkeypatch.setattr(sys, "stdout", shown)
    table = RichTable(title=NASTY)
    table.add_column(NASTY)
    table.add_row(NASTY)
    printer = Printer()
    printer.print(table)
    printer.print(f"{NASTY}, 40 N·m/s²", soft_wrap=True)
    text = shown.getvalue()
    assert all(line.isprintable() for line in text.splitlines())
    assert "phase" in text
    assert "40 N·m/s²" in text


@pytest.mark.parametrize("columns", [3, 12, 40])
def test_no_cell_of_a_wide_table_is_cut(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = io.StringIO()
    monkeypatch.setattr(sys, "stdout", shown)
    rows = [[f"name_of_row_{row}", *(f"{row}.{column:08}" for column in range(1, columns))] for row in range(2)]
    print_rich(Table([f"a{column}" for column in range(columns)], rows, title="numbers"))
    lines = shown.getvalue().splitlines()
    assert max(map(len, lines)) <= 140
    words = shown.getvalue().split()
    assert words.count("numbers") == 1
    for row in rows:
        assert all(word in words for word in row)
        assert words.count(row[0]) == words.count("a0")


def test_figures() -> None:
    assert figure(1.25, ".1f") == "1.2"
    assert figure(None, ".1f") == figure(float("nan"), ".1f") == figure(float("inf"), ".3g") == "-"
