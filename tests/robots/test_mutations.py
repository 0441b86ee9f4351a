"""Whatever is done to a card or a model, it loads as a valid robot or is refused in one line."""

from __future__ import annotations

import copy
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.robots.samples import BHR, MODELS, build, build_model, card_data
from tests.robots.test_urdf import as_urdf, urdf_card

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.robots.footing import check_soles
from gaitsmith.robots.model_file import open_model
from gaitsmith.robots.robot import Robot, describe

JUNK: list[Any] = [None, True, 0, -1, 1, 0.05, 1e-300, 1e308, -1e308, math.nan, math.inf, 10**400, "", "x", "nan", "\0"]
JUNK += [
    "left_knee",
    "torso",
    "world",
    "../x",
    "é" * 300,
    [],
    {},
    [0.0, 0.0],
    [[]],
    {"a": 1},
    "line",
    ["left_knee"] * 4,
]
WORDS = ["", "nan", "-1", "0", "1", "1e308", "1e-300", "1 0 0", "0 0 0", "0 0 0 0", "true", "free", "ball", "slide"]
WORDS += [
    "torso",
    "left_knee",
    "knee",
    "world",
    "mesh",
    "box",
    "1 2 3 4 5 6 7 8 9",
    "a" * 500,
    "\u20ac",
    "9" * 40,
    "../x",
    "%s%n",
    "none.stl",
]
CARDS = {path: card_data(path) for path in (BHR / "card.toml", MODELS / "with_arms.toml")}


@pytest.fixture(autouse=True, scope="module")
def quiet_folder() -> Iterator[Path]:
    """MuJoCo may write its log into the working folder; nothing may be there afterwards."""
    with tempfile.TemporaryDirectory() as name, pytest.MonkeyPatch.context() as patch:
        patch.chdir(name)
        yield Path(name)
        assert [path.name for path in Path(name).iterdir()] == []


def places(tree: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Paths of every entry of nested tables and lists."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in items:
        yield (*path, key)
        yield from places(value, (*path, key))


@st.composite
def mutated_cards(draw: st.DrawFn) -> tuple[dict[str, Any], Path]:
    path = draw(st.sampled_from(list(CARDS)))
    data = copy.deepcopy(CARDS[path])
    for _ in range(draw(st.integers(1, 3))):
        spots = list(places(data))
        spot = draw(st.sampled_from(spots))
        parent: Any = data
        for key in spot[:-1]:
            parent = parent[key]
        match draw(st.sampled_from(["junk", "number", "scaled", "removed", "copied", "added"])):
            case "removed":
                del parent[spot[-1]]
            case "copied":
                other: Any = data
                for key in draw(st.sampled_from(spots)):
                    other = other[key]
                parent[spot[-1]] = copy.deepcopy(other)
            case "added" if isinstance(parent, dict):
                parent[draw(st.text(max_size=5))] = copy.deepcopy(draw(st.sampled_from(JUNK)))
            case "scaled" if isinstance(parent[spot[-1]], float):
                parent[spot[-1]] *= draw(st.floats(0.5, 2.0))
            case "number":
                parent[spot[-1]] = draw(st.floats())
            case _:
                parent[spot[-1]] = copy.deepcopy(draw(st.sampled_from(JUNK)))
    return data, path.parent


def valid(robot: Robot) -> None:
    """A loaded robot keeps what its docstring promises."""
    n = len(robot.joint_names)
    assert robot.model.nv == n + 6 == robot.model.nu + 6
    assert (robot.position_low < robot.position_high).all()
    assert (robot.torque_limit > 0).all()
    assert (robot.velocity_limit > 0).all()
    assert robot.mass > 0
    assert [leg.side for leg in robot.legs] == [1, -1]
    for leg in robot.legs:
        assert np.isfinite(leg.sole_position).all()
        assert leg.sole_rotation @ leg.sole_rotation.T == pytest.approx(np.eye(3), abs=1e-9)
        assert robot.joint_names[leg.knee] in leg.joints
    assert describe(robot)["joints"] == list(robot.joint_names)


def refused(error: BadInput) -> None:
    assert "\n" not in str(error)
    assert ": got " in str(error)
    assert "expected " in str(error)


@settings(max_examples=600)
@given(mutated_cards())
def test_any_card_loads_or_is_refused(example: tuple[dict[str, Any], Path]) -> None:
    try:
        robot = build(*example)
    except BadInput as error:
        refused(error)
    else:
        valid(robot)


@st.composite
def mutated_models(draw: st.DrawFn, source: bytes) -> bytes:
    root = ElementTree.fromstring(source)
    for _ in range(draw(st.integers(1, 3))):
        elements = list(root.iter())
        element = draw(st.sampled_from(elements))
        parents = {child: parent for parent in elements for child in parent}
        match draw(st.sampled_from(["value", "number", "added", "removed", "moved", "doubled", "renamed", "unset"])):
            case "value" if element.attrib:
                element.set(draw(st.sampled_from(sorted(element.attrib))), draw(st.sampled_from(WORDS)))
            case "number" if element.attrib:
                element.set(draw(st.sampled_from(sorted(element.attrib))), repr(draw(st.floats())))
            case "added":
                names = sorted({name for other in elements for name in other.attrib})
                element.set(draw(st.sampled_from(names)), draw(st.sampled_from(WORDS)))
            case "unset" if element.attrib:
                del element.attrib[draw(st.sampled_from(sorted(element.attrib)))]
            case "removed" if element in parents:
                parents[element].remove(element)
            case "moved" if element in parents:
                target = draw(st.sampled_from(elements))
                if target not in set(element.iter()):
                    parents[element].remove(element)
                    target.append(element)
            case "doubled" if element in parents:
                parents[element].append(copy.deepcopy(element))
            case _:
                element.tag = draw(st.sampled_from(sorted({other.tag for other in elements})))
    return ElementTree.tostring(root)


@settings(max_examples=300)
@given(mutated_models((MODELS / "with_arms.xml").read_bytes()))
def test_any_model_without_a_card_opens_or_is_refused(text: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "model.xml").write_bytes(text)
        try:
            found = open_model(Path(folder) / "model.xml")
            assert found.model.njnt == 1 + len(found.limits)
        except BadInput as error:
            refused(error)
        else:
            assert set(found.limits) <= set(found.home)
            assert all(math.isfinite(angle) for angle in found.home.values())


def loads_or_is_refused(text: bytes, data: dict[str, Any] | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        try:
            robot = build_model(text, Path(folder), data)
            valid(robot)
            check_soles(robot)
        except BadInput as error:
            refused(error)


@settings(max_examples=300)
@given(mutated_models((BHR / "bhr_b2.xml").read_bytes()))
def test_any_mjcf_loads_or_is_refused(text: bytes) -> None:
    loads_or_is_refused(text, None)


URDF = ElementTree.tostring(as_urdf(load_robot("bhr_b2")))


@settings(max_examples=300)
@given(mutated_models(URDF))
def test_any_urdf_loads_or_is_refused(text: bytes) -> None:
    loads_or_is_refused(text, urdf_card())


@settings(max_examples=300)
@given(st.data())
def test_any_bytes_are_refused(data: st.DataObject) -> None:
    source = bytearray(data.draw(st.sampled_from([(BHR / "bhr_b2.xml").read_bytes(), URDF])))
    for _ in range(data.draw(st.integers(1, 5))):
        start = data.draw(st.integers(0, len(source) - 1))
        source[start : start + data.draw(st.integers(0, 40))] = data.draw(st.binary(max_size=20))
    loads_or_is_refused(bytes(source), None)
