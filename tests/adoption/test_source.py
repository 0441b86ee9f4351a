"""Models are found by path and by the names that installed packages give them; a package's failure is one line."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from gaitsmith.adoption.source import find_model
from gaitsmith.errors import BadInput


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of robot descriptions that nobody published."""
    folder = tmp_path / "robot_descriptions"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (tmp_path / "walker.urdf").write_text("<robot/>")
    (folder / "walker_description.py").write_text(f"URDF_PATH = {str(tmp_path / 'walker.urdf')!r}\n")
    (folder / "broken_mj_description.py").write_text("raise OSError('no network\\nat all')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    importlib.invalidate_caches()
    yield tmp_path
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        del sys.modules[name]


def test_a_path_is_itself(tmp_path: Path) -> None:
    path = tmp_path / "a robot.xml"
    path.write_text("<mujoco/>")
    assert find_model(str(path)) == path


def test_a_name_of_a_package(packages: Path) -> None:
    assert find_model("walker_description") == find_model("walker") == packages / "walker.urdf"


def test_what_a_package_cannot_give_is_refused_in_one_line(packages: Path) -> None:
    with pytest.raises(BadInput, match="no network at all"):
        find_model("broken")
    with pytest.raises(BadInput, match="MODEL"):
        find_model("unheard_of")


def test_a_folder_names_its_models(tmp_path: Path) -> None:
    (tmp_path / "walker.urdf").write_text("<robot/>")
    with pytest.raises(BadInput, match=r"walker\.urdf"):
        find_model(str(tmp_path))
