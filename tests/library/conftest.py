"""A small library, planned once: the grid of the page on libraries, with fewer speeds."""

import re
import tomllib
from pathlib import Path

import pytest

from gaitsmith.library.building import build
from gaitsmith.library.family import Family
from gaitsmith.library.folder import Folder
from gaitsmith.library.spec import checked_spec
from gaitsmith.robots import load_robot

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "library.md").read_text()
GRID = re.sub(r"speed = \[.*?\]", "speed = [0.2, 0.3]", PAGE.split("```toml\n")[1].split("```")[0], count=1)
SPEC = tomllib.loads(GRID)


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    folder = Folder(tmp_path_factory.mktemp("library") / "whole")
    built = build(checked_spec(SPEC), folder)
    assert built.base == "000-000-000"
    assert all(record.certified for record in built.records.values())
    return folder


@pytest.fixture(scope="session")
def family(library):
    return Family(library, load_robot("thbip_ii"))
