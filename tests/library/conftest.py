"""A small library, planned once."""

import pytest

from gaitsmith.library.building import build
from gaitsmith.library.family import Family
from gaitsmith.library.folder import Folder
from gaitsmith.library.spec import checked_spec
from gaitsmith.robots import load_robot

SPEC = {"robot": "thbip_ii", "speed": [0.2, 0.3], "period": [0.6, 0.7]}


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
