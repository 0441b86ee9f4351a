"""Where results go: refused before the work if it cannot be written, complete afterwards.

The folder of a run is there from the first tick on, so that whatever ends the run leaves what it had done.
"""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from gaitsmith.documents import toml
from gaitsmith.errors import BadInput
from gaitsmith.files import lock, reason, regular_target, why_unwritable, write_text_atomic

if TYPE_CHECKING:
    from gaitsmith.robots import Robot
    from gaitsmith.simulation import Scenario, Summary

LOG, SUMMARY, SCENARIO = "log.mcap", "summary.json", "scenario.toml"
FIGURE_ROWS = 150_000
"""Rows that figures are drawn from, at most; ten minutes of a run."""
_NEW = "a folder that does not exist yet"


def check_file(name: str, inputs: Iterable[str] = ()) -> Path:
    """Absolute path of a file for ``--out`` that can be written; a link is followed, ``inputs`` are not replaced.

    Raises:
        BadInput: it is one of the inputs or something else than a file, or its folder cannot be written.
    """
    try:
        target = regular_target(name)
    except BadInput as error:
        raise BadInput("--out", name, error.valid, f"that is {error.value}") from None
    for given in inputs:
        with contextlib.suppress(OSError, ValueError):
            if os.path.samefile(given, target):
                raise BadInput("--out", name, f"another file than {given}, which is read", "choose another name")
    if why := why_unwritable(target.parent):
        raise BadInput("--out", name, "a file in a folder that can be written", f"{target.parent}: {why}")
    return target


def run_files(folder: Path) -> list[str]:
    """What a run's folder is read for."""
    return [str(folder / name) for name in (LOG, SUMMARY, SCENARIO)]


def check_new_folder(name: str, field: str = "--out") -> Path:
    """Absolute path of a folder that can be created.

    Raises:
        BadInput: something exists there already, or its parent cannot be written.
    """
    folder = Path(os.path.abspath(name))
    try:
        os.lstat(folder)
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:
        raise BadInput(field, name, "a folder that can be created", reason(error)) from None
    else:
        raise BadInput(field, name, _NEW, "choose another name")
    parent = next(above for above in folder.parents if os.path.lexists(above))
    if why := why_unwritable(parent):
        raise BadInput(field, name, "a folder whose parent can be written", f"{parent}: {why}; choose another place")
    return folder


def folder_of(run: str | Path) -> Path:
    """The folder of a run, which its log stands for too."""
    path = Path(run)
    return path.parent if path.name == LOG and path.is_file() else path


def portable(scenario: Scenario) -> Scenario:
    """The scenario with its paths made absolute, so that it runs from any folder."""
    from gaitsmith.robots import robot_names

    found: dict[str, Any] = {"gait": tuple(os.path.realpath(path) for path in scenario.gait)}
    found |= {name: os.path.realpath(path) for name in ("policy", "library") if (path := getattr(scenario, name))}
    if scenario.footholds not in ("", "terrain"):
        found["footholds"] = os.path.realpath(scenario.footholds)
    if scenario.robot.replace("-", "_") not in robot_names() and os.path.exists(scenario.robot):
        found["robot"] = os.path.realpath(scenario.robot)
    return scenario.model_copy(update=found)


def log_notes(scenario: Scenario, robot: Robot, step: float, gait: dict[str, Any]) -> dict[str, Any]:
    """What a log says of its run: scenario, robot, control period (s), and the gait inputs commanded first."""
    return {
        "scenario": portable(scenario).model_dump(mode="json"),
        "robot": robot.card.name,
        "robot_hash": robot.content_hash,
        "control_step": step,
        "gait": gait,
    }


class NewFolder:
    """A folder, made with the parents that it lacks; all of them go again if nothing comes of it.

    Args:
        field: the flag.
    """

    def __init__(self, path: Path, field: str = "--out") -> None:
        self.path, self._field = path, field
        self._made: list[Path] = []

    def make(self) -> None:
        """Make it.

        Raises:
            BadInput: it cannot be made, or somebody else has taken the name meanwhile.
        """
        try:
            for above in reversed([self.path, *self.path.parents]):
                if above == self.path or not above.exists():
                    above.mkdir()
                    self._made.append(above)
        except FileExistsError:
            raise BadInput(self._field, str(self.path), _NEW, "choose another name") from None
        except OSError as error:
            raise BadInput(self._field, str(self.path), "a folder that can be created", reason(error)) from None

    def log(self) -> BinaryIO:
        """Make it, and the file of a run's log, which is locked as long as it is open."""
        from gaitsmith.log.record import new_file

        self.make()
        file = new_file(self.path / LOG)
        lock(file)
        return file

    def discard(self) -> None:
        """Remove what was made."""
        if self.path in self._made:
            shutil.rmtree(self.path, ignore_errors=True)
        with contextlib.suppress(OSError):
            for above in reversed(self._made[:-1]):
                above.rmdir()


def write_summary(folder: Path, summary: Summary) -> None:
    """Write the summary of a run, whole or not at all.

    Raises:
        BadInput: the disk is full.
    """
    write_text_atomic(folder / SUMMARY, summary.model_dump_json(indent=2) + "\n")


def scenario_toml(scenario: Scenario) -> str:
    """TOML text that :func:`gaitsmith.simulation.load_scenario` turns into the same scenario, every digit kept."""
    fields = scenario.model_dump(mode="json", exclude_none=True)
    return "".join(f"{name} = {toml(value)}\n" for name, value in fields.items())
