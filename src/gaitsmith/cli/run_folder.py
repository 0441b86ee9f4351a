"""Where results go: refused before the work if it cannot be written, complete afterwards.

The folder of figures appears once it is complete. The folder of a run is there from the first tick on, so that whatever
ends the run leaves what it had done.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from gaitsmith.errors import BadInput
from gaitsmith.files import lock, regular_target, why_unwritable, write_text_atomic

if TYPE_CHECKING:
    from gaitsmith.simulation import Scenario, Summary

LOG, SUMMARY = "log.mcap", "summary.json"
FIGURE_ROWS = 150_000
"""Rows that figures are drawn from, at most; ten minutes of a run."""
_NEW = "a folder that does not exist yet"


def check_file(name: str, inputs: Iterable[str] = (), field: str = "--out") -> Path:
    """Absolute path of a file that can be written; a link is followed.

    Args:
        name: as the user wrote it.
        inputs: paths that the command reads, and that it therefore must not replace.
        field: the flag.

    Raises:
        BadInput: it is one of the inputs or something else than a file, or its folder cannot be written.
    """
    try:
        target = regular_target(name)
    except BadInput as error:
        raise BadInput(field, name, error.valid, f"that is {error.value}") from None
    for given in inputs:
        if _same(given, target):
            raise BadInput(field, name, f"another file than {given}, which is read", "choose another name")
    reason = why_unwritable(target.parent)
    if reason:
        raise BadInput(field, name, "a file in a folder that can be written", f"{target.parent}: {reason}")
    return target


def _same(given: str, target: Path) -> bool:
    try:
        return os.path.samefile(given, target)
    except (OSError, ValueError):
        return False


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
        reason = getattr(error, "strerror", None) or str(error)
        raise BadInput(field, name, "a folder that can be created", reason.lower()) from None
    else:
        raise BadInput(field, name, _NEW, "choose another name")
    parent = next(above for above in folder.parents if os.path.lexists(above))
    reason = why_unwritable(parent)
    if reason:
        raise BadInput(field, name, "a folder whose parent can be written", f"{parent}: {reason}; choose another place")
    return folder


@contextlib.contextmanager
def new_folder(folder: Path, field: str = "--out") -> Iterator[Path]:
    """A hidden folder to write into; it takes its final name when everything is written.

    Raises:
        BadInput: it cannot be written, or somebody else has taken the name meanwhile.
    """
    missing = [above for above in folder.parents if not above.exists()]
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=f".{folder.name[:60]}.", dir=folder.parent))
    except OSError as error:
        raise BadInput(field, str(folder), "a folder that can be created", (error.strerror or "").lower()) from None
    try:
        yield staging
    except BaseException:
        shutil.rmtree(staging, ignore_errors=True)
        with contextlib.suppress(OSError):
            for above in missing:
                above.rmdir()
        raise
    mask = os.umask(0)
    os.umask(mask)
    staging.chmod(0o777 & ~mask)  # the temporary folder was private
    try:
        if os.path.lexists(folder):
            raise FileExistsError
        staging.rename(folder)
    except OSError:
        raise BadInput(field, str(folder), _NEW, f"the run is kept in {staging}") from None


class RunFolder:
    """The folder of one run, made when its log begins.

    Args:
        path: of the folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._made: list[Path] = []

    def log(self) -> BinaryIO:
        """Make the folder and the file of the log; the file is locked as long as it is open.

        Raises:
            BadInput: it cannot be made, or somebody else has taken the name meanwhile.
        """
        try:
            for above in reversed([self.path, *self.path.parents]):
                if above == self.path or not above.exists():
                    above.mkdir()
                    self._made.append(above)
            file = open(self.path / LOG, "x+b", buffering=0)  # noqa: SIM115 - the run closes it
        except FileExistsError:
            raise BadInput("--out", str(self.path), _NEW, "choose another name") from None
        except OSError as error:
            reason = (error.strerror or "").lower()
            raise BadInput("--out", str(self.path), "a folder that can be created", reason) from None
        lock(file)
        return file

    def discard(self) -> None:
        """Remove what :meth:`log` has made: nothing was recorded."""
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
    tables = {name: value for name, value in fields.items() if isinstance(value, dict)}
    lists = {name: value for name, value in fields.items() if name in ("changes", "pushes")}
    parts = [_table({name: value for name, value in fields.items() if name not in tables and name not in lists})]
    parts += [f"[{name}]\n{_table(value)}" for name, value in tables.items()]
    parts += [f"[[{name}]]\n{_table(entry)}" for name, value in lists.items() for entry in value]
    return "\n".join(parts)


def _table(fields: Mapping[str, Any]) -> str:
    return "".join(f"{name} = {_value(value)}\n" for name, value in fields.items())


def _value(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    text = json.dumps(value, ensure_ascii=False)
    return text.replace("\x7f", "\\u007f") if isinstance(value, str) else text
