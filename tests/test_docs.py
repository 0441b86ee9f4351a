"""The docs against the code: links, modules, functions, tests and card entries that they name exist, and none lacks."""

import importlib.util
import re
import sys
from pathlib import Path
from types import UnionType
from typing import Any, get_args

import pytest
from pydantic import BaseModel

from gaitsmith.cli import main
from gaitsmith.cli.dispatch import COMMANDS
from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.reproduction.as_printed import changed
from gaitsmith.robots import load_robot
from gaitsmith.robots.card import Assumption, JointLimits, LegCard, RobotCard, Sole
from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.robots.presets import ControlParameters

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "gaitsmith"
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


def page(name: str) -> str:
    return (ROOT / "docs" / name).read_text()


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_links_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)", path.read_text()):
        assert "://" in target or (path.parent / target).exists(), target


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_scripts_and_tests_that_are_named_exist(path: Path) -> None:
    for name in re.findall(r"\b((?:benchmarks|examples|tests)/[\w/]+\.py)", path.read_text()):
        assert (ROOT / name).is_file(), name


@pytest.mark.parametrize(("paper", "last"), [("Gait template and whole-body control", 32), ("Gait synthesis", 31)])
def test_every_equation_is_mapped_to_a_function(paper: str, last: int) -> None:
    text = page("equations.md").split(f"## {paper}\n")[1].split("\n## ")[0]
    mapped: list[int] = []
    for numbers, places in re.findall(r"^\| ([\d–]+) \|[^|]*\|([^|]*)\|", text, re.M):
        first, _, final = numbers.partition("–")
        mapped += range(int(first), int(final or first) + 1)
        for module, functions in re.findall(r"`([\w/]+\.py)`: (`\w+`(?:, `\w+`)*)", places):
            source = (SOURCE / module).read_text()
            for function in re.findall(r"`(\w+)`", functions):
                assert f"def {function}(" in source, f"{module}: {function}"
    assert mapped == list(range(1, last + 1))


def test_every_test_of_an_equation_exists() -> None:
    named = re.findall(r"`([\w/]*test_\w+\.py)?(?:::(test_\w+))?`", page("equations.md"))
    source = ""
    for file, function in named:
        if file:
            source = (ROOT / "tests" / file.removeprefix("tests/")).read_text()
        assert not function or f"def {function}(" in source, f"{file}: {function}"


def test_every_module_is_in_the_design() -> None:
    text = page("design.md")
    for folder in sorted(path for path in SOURCE.iterdir() if (path / "__init__.py").exists()):
        for module in folder.rglob("[a-z]*.py"):
            assert f"`{module.stem}`" in text or f"{folder.name}/{module.name}" in text, module


def entries(model: type[BaseModel], prefix: str = "") -> list[str]:
    """Names of a model's fields, those of groups dotted."""
    found = []
    for name, field in model.model_fields.items():
        kinds: tuple[Any, ...] = get_args(field.annotation) if isinstance(field.annotation, UnionType) else ()
        group = next((k for k in (field.annotation, *kinds) if isinstance(k, type) and issubclass(k, BaseModel)), None)
        found += entries(group, f"{prefix}{name}.") if group else [f"{prefix}{name}"]
    return found


@pytest.mark.parametrize("model", [RobotCard, LegCard, Sole, JointLimits, GaitParameters, Assumption])
def test_every_card_entry_is_explained(model: type[BaseModel]) -> None:
    text = page("cards.md")
    for name in model.model_fields:
        assert re.search(rf"[`\[.]{name}[`\].]", text), name


def test_every_preset_number_is_explained() -> None:
    text = page("cards.md")
    for name in entries(ControlParameters):
        assert f"`{name}`" in text or f"`{name.partition('.')[0]}.*`" in text, name


def test_every_measured_deviation_is_a_valid_preset_and_in_the_table() -> None:
    spec = importlib.util.spec_from_file_location("deviations", ROOT / "benchmarks" / "deviations.py")
    assert spec is not None
    assert spec.loader is not None
    benchmark = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = benchmark
    spec.loader.exec_module(benchmark)
    robot = load_robot("bhr_b2")
    scale = robot_scale(robot)
    default = preset_parameters(robot, scale, "default")
    for row in benchmark.deviations(robot):
        parameters = changed(default, row.numbers)
        assert (parameters != default) == bool(row.numbers)
        assert f"| {row.name} |" in page("deviations.md"), row.name
    paper = preset_parameters(robot, scale, "paper")
    assert changed(default, paper.model_dump()) == paper


def test_every_assumption_is_listed() -> None:
    for assumption in load_robot("bhr_b2").card.assumptions:
        assert assumption.what in page("deviations.md")


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_commands_in_code_blocks_have_the_options_they_are_given(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for block in re.findall(r"```(?:sh)?\n(.*?)```", path.read_text(), re.S):
        for line in re.findall(r"^gaitsmith (.*?)(?: +#.*)?$", block, re.M):
            words = line.split()
            name = words[: 2 if tuple(words[:2]) in COMMANDS else 1]
            assert main([*name, "--help"]) == 0, line
            told = capsys.readouterr().out
            assert all(flag in told for flag in re.findall(r"--[\w-]+", line)), line
