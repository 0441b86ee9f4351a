"""Whatever words are given, the result is a value of the declared type or one BadInput."""

from dataclasses import dataclass
from typing import Annotated

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitsmith.cli.arguments import Positional, Repeatable, choice, integer, number, numbers, parse, text
from gaitsmith.errors import BadInput


@dataclass(frozen=True)
class Options:
    """One of every kind."""

    file: Annotated[str | None, Positional, text("FILE", "FILE")] = None
    """a file"""
    speed: Annotated[tuple[float, ...] | None, numbers("--speed", "VX [VY]", (1, 2), "file first")] = None
    """speed, m/s"""
    push: Annotated[tuple[Annotated[str, text("--push", "t,Jx,Jy,Jz")], ...], Repeatable] = ()
    """a push"""
    state: Annotated[str | None, choice("--state", ("true", "estimated"))] = None
    """which state"""
    joint_friction: Annotated[float | None, number("--joint-friction", "N·m")] = None
    """friction"""
    seed: Annotated[int | None, integer("--seed", "N", 0)] = None
    """seed"""
    json: bool = False
    """one JSON document"""


def read(*words: str) -> Options:
    return parse(Options, words, "gaitsmith try")


def test_every_option_is_read() -> None:
    words = "walk.toml --speed -0.4 .1 --push 4,0,-15,0 --push -1,2,3,4 --state estimated --joint-friction=3 --seed 7"
    assert read(*words.split(), "--json") == Options(
        file="walk.toml",
        speed=(-0.4, 0.1),
        push=("4,0,-15,0", "-1,2,3,4"),
        state="estimated",
        joint_friction=3.0,
        seed=7,
        json=True,
    )


@pytest.mark.parametrize(
    ("words", "field", "part"),
    [
        (["--speed"], "--speed", "1 or 2 numbers"),
        (["--speed", "fast"], "--speed", "'fast'"),
        (["--speed", "1", "2", "3"], "--speed", "1 or 2 numbers"),
        (["--speed", "0.3", "walk.toml"], "--speed", "file first"),
        (["--speed", "nan"], "--speed", "finite"),
        (["--joint-friction", "inf"], "--joint-friction", "finite"),
        (["--joint-friction"], "--joint-friction", "nothing"),
        (["--seed", "1.5"], "--seed", "whole number from 0"),
        (["--seed", "-1"], "--seed", "whole number from 0"),
        (["--state", "estimate"], "--state", "did you mean estimated?"),
        (["--sped", "1"], "option", "did you mean --speed?"),
        (["--xyzzy"], "option", "--help"),
        (["a", "b"], "argument", "'b'"),
        (["--json=yes"], "--json", "write --json alone"),
        ([""], "FILE", "''"),
        (["a\0b"], "FILE", "FILE"),
    ],
)
def test_what_is_wrong_is_named(words: list[str], field: str, part: str) -> None:
    with pytest.raises(BadInput) as caught:
        read(*words)
    assert caught.value.field == field
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_help_lists_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        read("--help")
    shown = capsys.readouterr().out
    assert end.value.code == 0
    for flag in ("--speed", "--push", "--state", "--joint-friction", "--seed", "--json"):
        assert flag in shown


WORDS = st.one_of(
    st.sampled_from(
        ["--speed", "--push", "--state", "--joint-friction", "--seed", "--json", "--", "-", "--no-json", "-x", "true"]
    ),
    st.floats().map(str),
    st.integers().map(str),
    st.text(max_size=8).filter(lambda word: word not in ("-h", "--help")),
)


@settings(max_examples=300)
@given(st.lists(WORDS, max_size=8))
def test_random_words_parse_or_are_refused_in_one_line(words: list[str]) -> None:
    try:
        options = read(*words)
    except BadInput as error:
        assert len(str(error).splitlines()) == 1
    else:
        assert options.speed is None or 1 <= len(options.speed) <= 2
        assert options.state in (None, "true", "estimated")
        assert options.seed is None or options.seed >= 0
