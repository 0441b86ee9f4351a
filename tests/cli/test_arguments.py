"""Whatever words are given, the result is a value of the declared type or one BadInput."""

import contextlib
import re
from typing import Annotated, Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, Field

from gaitsmith.cli import main
from gaitsmith.cli.arguments import Arguments, Positional, overriding, parse
from gaitsmith.cli.dispatch import COMMANDS
from gaitsmith.documents import About
from gaitsmith.errors import BadInput


class Push(BaseModel):
    """A table that is written with commas."""

    time: Annotated[float, Field(ge=0.0)]
    impulse: tuple[float, float, float]
    body: str = "torso"


class Options(Arguments):
    """One of every kind."""

    file: Annotated[str | None, Positional("A file", metavar="FILE")] = None
    speed: Annotated[tuple[float, float] | None, About("Speed", "m/s", "VX [VY]")] = None
    push: Annotated[tuple[Push, ...], About("A push", metavar="t,Jx,Jy,Jz")] = ()
    only: Annotated[tuple[str, ...], About("A name", metavar="NAME")] = ()
    state: Annotated[Literal["true", "estimated"] | None, About("Which state")] = None
    order: Annotated[Literal[4, 5], About("Degree")] = 5
    joint_friction: Annotated[float | None, Field(ge=0.0, le=9.0), About("Friction", "N·m", "N·m", absent="none")] = (
        None
    )
    seed: Annotated[int, Field(ge=0, le=100), About("Seed", metavar="N")] = 3
    dry: Annotated[bool, About("Do nothing")] = False
    hidden: int = 7


def read(*words: str) -> Options:
    return parse(Options, words, "gaitsmith try")


def test_every_option_is_read() -> None:
    words = "walk.toml --speed -0.4 .1 --push 4,0,-15,0 --push 1,2,3,4 --state estimated --joint-friction=3 --seed 7"
    assert read(*words.split(), "--only", "a", "--order", "4", "--json", "--dry") == Options(
        file="walk.toml",
        speed=(-0.4, 0.1),
        push=(Push(time=4.0, impulse=(0.0, -15.0, 0.0)), Push(time=1.0, impulse=(2.0, 3.0, 4.0))),
        only=("a",),
        state="estimated",
        order=4,
        joint_friction=3.0,
        seed=7,
        dry=True,
        json_=True,
    )
    assert read() == Options()


def test_what_is_in_brackets_may_be_left_out() -> None:
    assert read("--speed", "-.5").speed == (-0.5, 0.0)
    assert read("--speed=1e-1", "--", "-x").speed == (0.1, 0.0)
    assert read("--", "-x").file == "-x"


@pytest.mark.parametrize(
    ("words", "field", "part"),
    [
        (["--speed"], "--speed", "1 or 2 finite numbers"),
        (["--speed", "fast"], "--speed", "'fast'"),
        (["--speed", "1", "2", "3"], "--speed", "1 or 2 finite numbers"),
        (["--speed", "0.3", "walk.toml"], "--speed", "name the FILE before"),
        (["--speed", "nan"], "--speed", "finite"),
        (["--push", "-1,0,1,0"], "--push time", "from 0"),
        (["--push", "1,0,1"], "--push", "for example --push 1,2,3,4"),
        (["--push", "1,0,1,x"], "--push", "4 finite numbers"),
        (["--joint-friction", "10"], "--joint-friction", "from 0 to 9"),
        (["--order", "6"], "--order", "one of 4, 5"),
        (["--only", " "], "--only", "not empty"),
        (["--hidden", "1"], "option", "an option of"),
        (["--json-", "1"], "option", "did you mean --json?"),
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


class Needed(Arguments):
    """An option that has no default."""

    out: Annotated[str, About("Folder of the results", metavar="DIR")]


def test_an_option_that_is_needed_is_asked_for_and_marked(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(BadInput, match=r"--out: got nothing, expected a value \(Folder of the results\)"):
        parse(Needed, [], "gaitsmith try")
    with pytest.raises(SystemExit):
        parse(Needed, ["--help"], "gaitsmith try")
    assert "Folder of the results. (required)" in capsys.readouterr().out


def test_help_lists_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        read("--help")
    shown = capsys.readouterr().out
    assert end.value.code == 0
    assert "(default: none, from 0 to 9)" in shown
    assert "(default: 3, from 0 to 100)" in shown
    assert "[FILE]" in shown
    assert "hidden" not in shown
    assert shown.rindex("--json") > shown.rindex("--dry")
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
        assert options.speed is None or len(options.speed) == 2
        assert options.state in (None, "true", "estimated")
        assert 0 <= options.seed <= 100


class Model(BaseModel):
    """What a command's options may override."""

    size: Annotated[float, Field(gt=0.0, le=2.0), About("Size", "m", "M")] = 1.5
    kind: Annotated[str | None, About("Kind", metavar="KIND")] = None
    map: Annotated[str, About("Map", metavar="FILE")] = ""
    shift: Annotated[tuple[float, float], About("Shift", "m", "X Y")] = (0.0, 0.5)
    inner: Push = Push(time=0.0, impulse=(0.0, 0.0, 0.0))


class Own(Arguments):
    """A command."""

    out: Annotated[str | None, About("Where to", metavar="DIR")] = None


def test_a_model_s_described_fields_are_options_that_may_be_left_out(capsys: pytest.CaptureFixture[str]) -> None:
    """Adding a field to the model adds the option: nothing else names it."""
    combined = overriding(Own, Model, "the robot's")
    assert parse(combined, [], "try").model_dump(exclude_none=True) == {"json_": False}
    found = parse(combined, ["--size", "1", "--out", "x"], "try").model_dump()
    assert found == {"json_": False, "out": "x", "size": 1.0, "kind": None, "map": None, "shift": None}
    with pytest.raises(BadInput, match=r"--size: got 3\.0, expected a finite number above 0 up to 2"):
        parse(combined, ["--size", "3"], "try")
    with pytest.raises(SystemExit):
        parse(combined, ["--help"], "try")
    shown = " ".join(capsys.readouterr().out.split())
    assert "--size M Size, m. (default: 1.5, above 0 up to 2)" in shown
    assert "--kind KIND Kind. (default: the robot's)" in shown
    assert "--map FILE Map. (default: none)" in shown
    assert "--shift X Y Shift, m. (default: 0 0.5)" in shown
    assert shown.index("--kind") < shown.index("--out")
    with pytest.raises(BadInput, match="did you mean --size"):
        parse(combined, ["--siz", "3"], "try")


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_every_option_that_takes_a_value_says_which(path: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    """A line of the help with an option alone on it is a switch, and a switch takes no value."""
    with contextlib.suppress(SystemExit):
        main([*path, "--help"])
    shown = re.findall(r"^  (--[a-z-]+)(?:  .*)?$", capsys.readouterr().out, re.MULTILINE)
    for option in shown:
        with contextlib.suppress(SystemExit):
            main([*path, f"{option}=0x"])
        assert "expected no value" in capsys.readouterr().err, option
