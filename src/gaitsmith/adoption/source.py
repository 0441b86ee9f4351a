"""A model file by path, or by the name that an installed package of robot models gives it."""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
import re
from collections.abc import Callable
from pathlib import Path

from gaitsmith.documents import nearest
from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_ENDINGS = ("", "_mj_description", "_description")
_SHARE = "cmeel.prefix/share/example-robot-data/robots"
_BESIDE, _SCENE = 40, 1_000_000  # files beside a model that are looked at, bytes of each
PACKAGES = "robot_descriptions, mujoco-menagerie or example-robot-data"


def find_model(given: str) -> Path:
    """The model file of a path or a name.

    Names are asked of the packages that are installed: `robot_descriptions`, `mujoco-menagerie` (either downloads what
    it does not have yet), and the files of `example-robot-data`.

    Raises:
        BadInput: neither a file nor a known name, or a package cannot hand the model over.
    """
    path = Path(given)
    try:
        if path.is_file():
            return path
        if path.is_dir():
            found = sorted(p for ending in ("*.xml", "*.urdf") for p in path.glob(ending))
            names = ", ".join(p.name for p in found[:8]) or "no model"
            raise BadInput("MODEL", given, f"a model file, MJCF or URDF, not a folder; in it: {names}")
    except (OSError, ValueError):
        pass
    if not _NAME.fullmatch(given):
        raise BadInput("MODEL", given, "a model file, MJCF or URDF")
    asked: list[Callable[[str], Path | None]] = [_example, _menagerie, _described]
    for ask in asked:
        model = ask(given)
        if model is not None:
            return model
    known = [*_examples(), *_menagerie_names()]
    valid = f"a model file, MJCF or URDF, or a name that {PACKAGES} knows"
    raise BadInput("MODEL", given, valid, nearest(given, known) or "install gaitsmith[names]")


def including(path: Path) -> list[Path]:
    """Files beside a model that include it, such as its scenes: they may say what collides."""
    wanted = re.compile(rb"<include\s+file\s*=\s*[\"'](?:\./)?" + re.escape(path.name.encode()) + rb"[\"']")
    try:
        beside = sorted(other for other in path.parent.glob("*.xml") if other != path)[:_BESIDE]
        return [other for other in beside if wanted.search(read_bounded(other, _SCENE))]
    except (OSError, BadInput):
        return []


def _examples() -> dict[str, Path]:
    """URDF files of example-robot-data by name."""
    try:
        folder = Path(str(importlib.metadata.distribution("example-robot-data").locate_file(_SHARE)))
    except importlib.metadata.PackageNotFoundError:
        return {}
    return {path.stem: path for path in sorted(folder.glob("*/*/*.urdf"))}


def _example(name: str) -> Path | None:
    found = _examples()
    if name in found or not found:
        return found.get(name)
    inside = {stem: path for stem, path in found.items() if path.parts[-3].partition("_")[0] == name}
    if len(inside) > 1:
        raise BadInput("MODEL", name, f"one of {', '.join(inside)}")
    return next(iter(inside.values()), None)


def _menagerie_names() -> list[str]:
    try:
        return list(importlib.import_module("mujoco_menagerie").names())
    except ImportError:
        return []


def _menagerie(name: str) -> Path | None:
    if name not in _menagerie_names():
        return None
    robot = importlib.import_module("mujoco_menagerie").get(name)
    return _handed_over(name, lambda: robot.xml(robot.default_model))


def _described(name: str) -> Path | None:
    for ending in _ENDINGS:
        module = f"robot_descriptions.{name}{ending}"
        try:
            if importlib.util.find_spec(module) is None:
                continue
        except (ImportError, ValueError):
            return None

        def path(module: str = module) -> Path | None:
            described = importlib.import_module(module)
            found = getattr(described, "MJCF_PATH", None) or getattr(described, "URDF_PATH", None)
            return None if found is None else Path(found)

        return _handed_over(name, path)
    return None


def _handed_over(name: str, ask: Callable[[], Path | None]) -> Path | None:
    """What another package gives; its own failures, such as no network, are the user's."""
    try:
        return ask()
    except Exception as error:
        remedy = " ".join(str(error).split())[:200]
        raise BadInput("MODEL", name, "a model that its package can provide", remedy) from None
