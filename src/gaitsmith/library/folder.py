"""A library's folder: what it is to hold, a record and a gait file a point, and an index once it is whole.

``library.json`` says what is planned, ``points/`` has a record a point, ``gaits/`` the gait files, ``warm/`` what a
neighbour starts from. A record is written last, so a point without one has to be planned. ``index.json`` ends the work:
it holds a hash of every record and gait.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from gaitsmith.compiled.cache import source_key
from gaitsmith.documents import Frozen, checked, parse_json, written_as
from gaitsmith.errors import BadInput
from gaitsmith.files import UNFINISHED, lock, read_bounded, reason, write_bytes_atomic, write_text_atomic
from gaitsmith.library.spec import Index, Spec, checked_spec, key_of, point_of
from gaitsmith.robots import Robot
from gaitsmith.synthesis import Gait, read_gait

FORMAT = "gaitsmith-library"
VERSION = 2
_PLANNER = "gaitsmith.library.building"  # gaits of two versions are not mixed
START, STOP = "start", "stop"
"""What keys of motions from and to rest begin with."""
_LIMIT, _GAIT = 20_000_000, 50_000_000  # bytes
_PARTS = ("points", "gaits", "warm")
_REMEDY = "build it again into another folder"
_Digest = Annotated[str, written_as(r"[0-9a-f]{64}", "64 digits, 0 to f")]
_NoDigest = Annotated[str, written_as(r"([0-9a-f]{64})?", "64 digits, 0 to f, or nothing")]


class Record(Frozen):
    """What became of a point.

    Attributes:
        status: ``certified``, or ``failed``.
        reason: why there is no gait, in words.
        objective: J, 0 without a gait.
        iterations: of all solves.
        origin: key of the neighbour that the plan started from; empty if it started from nothing.
        parameters: of the step.
        gait, warm: SHA-256 of the gait file, and of what a neighbour starts from; empty without them.
    """

    status: Literal["certified", "failed"]
    reason: Annotated[str, Field(max_length=2000)] = ""
    objective: float = 0.0
    iterations: Annotated[int, Field(ge=0)] = 0
    origin: Annotated[str, Field(max_length=40)] = ""
    parameters: dict[str, float] = Field(default_factory=dict)
    gait: _NoDigest = ""
    warm: _NoDigest = ""

    @property
    def certified(self) -> bool:
        """Whether there is a gait."""
        return self.status == "certified"


class _Head(Frozen):
    """``library.json``."""

    format: Literal["gaitsmith-library"]
    version: Literal[2]
    robot_hash: _Digest
    planner: _Digest
    spec: dict[str, Any]
    checksum: _Digest


class _Index(Frozen):
    """``index.json``."""

    base: Annotated[str, Field(max_length=40)]
    records: Annotated[dict[str, _Digest], Field(max_length=10_010)]
    checksum: _Digest


def digest(content: bytes) -> str:
    """SHA-256 of some bytes."""
    return hashlib.sha256(content).hexdigest()


def _text(data: Any) -> str:
    return json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False) + "\n"


def _signed(data: dict[str, Any]) -> str:
    return _text(data | {"checksum": digest(_text(data).encode())})


class Folder:
    """A library on disk.

    Args:
        path: its folder.

    Attributes:
        path: the same.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)

    def begin(self, spec: Spec, robot: Robot) -> None:
        """Make the folder, or go on with one that is to hold the same.

        Raises:
            BadInput: it cannot be made, or it holds something else.
        """
        head = {"format": FORMAT, "version": VERSION, "robot_hash": robot.content_hash}
        head |= {"planner": digest(source_key(_PLANNER).encode()), "spec": spec.model_dump(mode="json")}
        text = _signed(head)
        try:
            used = self.path.is_dir() and any(self.path.iterdir())
            if used and read_bounded(self.path / "library.json", _LIMIT) != text.encode():
                raise BadInput(
                    "--out", str(self.path), "a new folder, or one begun with the same SPEC, robot and version"
                )
            for part in _PARTS:
                (self.path / part).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInput("--out", str(self.path), "a folder that can be written", reason(error)) from None
        write_text_atomic(self.path / "library.json", text)

    @contextlib.contextmanager
    def alone(self) -> Iterator[None]:
        """Keep other builds out, and clear away what one that was killed had begun to write.

        Raises:
            BadInput: another build is at work in the folder.
        """
        place = os.open(self.path, os.O_RDONLY)
        try:
            if not lock(place):
                valid = "a folder in which no other build is at work"
                raise BadInput("--out", str(self.path), valid, "wait for it, or stop it")
            for left in self.path.rglob(f".*{UNFINISHED}"):
                left.unlink(missing_ok=True)
            yield
        finally:
            os.close(place)

    def put(self, key: str, record: Record, gait: bytes, warm: bytes) -> None:
        """Keep what became of a point; the record last."""
        if record.certified:
            write_bytes_atomic(self._gait(key), gait)
            write_bytes_atomic(self._warm(key), warm)
        write_text_atomic(self.path / "points" / f"{key}.json", _text(record.model_dump(mode="json")))

    def get(self, key: str) -> Record | None:
        """What became of a point; None if that is not known, or if its files are not as they were written."""
        try:
            record = self._record(key)
            files = [(self._gait(key), record.gait), (self._warm(key), record.warm)] if record.certified else []
            return record if all(digest(read_bounded(path, _GAIT)) == known for path, known in files) else None
        except BadInput:
            return None

    def left(self, key: str) -> tuple[bytes, bytes]:
        """A point's gait file, and what a neighbour starts from.

        Raises:
            BadInput: it cannot be read.
        """
        return read_bounded(self._gait(key), _GAIT), read_bounded(self._warm(key), _GAIT)

    def end(self, base: str, keys: list[str]) -> None:
        """Write the index."""
        hashes = {key: digest(read_bounded(self.path / "points" / f"{key}.json", _LIMIT)) for key in keys}
        write_text_atomic(self.path / "index.json", _signed({"base": base, "records": hashes}))

    def spec(self) -> tuple[Spec, str]:
        """What the library is to hold, and its robot's hash.

        Raises:
            BadInput: no library, one of another version, or one that was edited.
        """
        head = self._read("library.json", _Head)
        return checked_spec(head.spec, f"{self.path / 'library.json'}: spec"), head.robot_hash

    def records(self) -> dict[str, Record]:
        """Records of all points so far, by key; of a finished library as :meth:`whole`.

        Raises:
            BadInput: as :meth:`spec`, or a record that cannot be read or was edited.
        """
        if os.path.lexists(self.path / "index.json"):
            return {key: record for key, record in self.whole()[1].items() if not key.startswith((START, STOP))}
        keys = [key_of(point) for point in self.spec()[0].points]
        return {key: self._record(key) for key in keys if os.path.lexists(self.path / "points" / f"{key}.json")}

    def whole(self) -> tuple[str, dict[str, Record]]:
        """Key of the gait that start and stop belong to (empty if none could be planned), and every record.

        Raises:
            BadInput: the library is not finished, or a record or gait file was edited.
        """
        spec, _ = self.spec()
        if not os.path.lexists(self.path / "index.json"):
            valid = "a finished library"
            raise BadInput(str(self.path), "no index.json", valid, "the command that built it goes on where it stopped")
        index = self._read("index.json", _Index)
        wanted = {key_of(point) for point in spec.points}
        sound, ends = set(index.records) >= wanted, set(index.records) - wanted
        if index.base and sound and index.base in wanted:
            bases = spec.on_slopes(point_of(index.base))
            sound = {*end_keys(spec, point_of(index.base))} <= ends <= {k for at in bases for k in end_keys(spec, at)}
        elif index.base or ends:
            sound = False
        if not sound:
            raise BadInput(str(self.path / "index.json"), "other points", "those of library.json", _REMEDY)
        found = {key: self._whole(key, expected) for key, expected in index.records.items()}
        for point in spec.points:
            record = found[key_of(point)]
            if record.certified and not _is_at(record.parameters, spec.place(point)):
                raise BadInput(f"{self.path}: {key_of(point)}", "another step", "the grid's", f"edited; {_REMEDY}")
        return index.base, found

    def _whole(self, key: str, expected: str) -> Record:
        """A record with this hash, whose gait file is as it was written."""
        path = self.path / "points" / f"{key}.json"
        if digest(read_bounded(path, _LIMIT)) != expected:
            raise BadInput(str(path), "another content", "the one that was planned", f"edited; {_REMEDY}")
        record = self._record(key)
        if record.certified:
            self._content(key, record)
        return record

    def gait(self, key: str, record: Record) -> Gait:
        """A gait.

        Raises:
            BadInput: its file is not the one that was planned.
        """
        self._content(key, record)
        gait, _ = read_gait(self._gait(key))
        if gait.motion.parameters != record.parameters:
            raise BadInput(str(self._gait(key)), "another step", "the one of its record", f"edited; {_REMEDY}")
        return gait

    def _content(self, key: str, record: Record) -> None:
        """Refuse a gait file that is not the one that was planned."""
        path = self._gait(key)
        if digest(read_bounded(path, _GAIT)) != record.gait:
            raise BadInput(str(path), "another content", "the one that was planned", f"edited; {_REMEDY}")

    def _gait(self, key: str) -> Path:
        return self.path / "gaits" / f"{key}.json"

    def _warm(self, key: str) -> Path:
        return self.path / "warm" / f"{key}.npz"

    def _record(self, key: str) -> Record:
        path = self.path / "points" / f"{key}.json"
        return checked(Record, _parsed(path), str(path))

    def _read(self, name: str, model: type[Any]) -> Any:
        path = self.path / name
        if not path.is_file():
            raise BadInput(str(self.path), f"no {name}", "a folder that gaitsmith library build wrote")
        data = _parsed(path)
        if not isinstance(data, dict) or (name == "library.json" and data.get("format") != FORMAT):
            raise BadInput(str(path), "something else", "a file that gaitsmith library build wrote")
        if name == "library.json" and data.get("version") != VERSION:
            raise BadInput(f"{path}: version", data.get("version"), str(VERSION), _REMEDY)
        found = checked(model, data, str(path))
        kept = {key: value for key, value in data.items() if key != "checksum"}
        if digest(_text(kept).encode()) != found.checksum:
            raise BadInput(f"{path}: checksum", found.checksum[:16], "the content's own", f"edited; {_REMEDY}")
        return found


def _is_at(step: dict[str, float], place: dict[str, float]) -> bool:
    """Whether a step is the one of a place in the grid."""
    if not {"length", "period", "height"} <= step.keys():
        return False
    own = {"speed": step["length"] / step["period"], "step_height": step["height"], "period": step["period"]}
    own |= {"yaw_rate": step.get("turn", 0.0) / step["period"], "slope": math.degrees(step.get("slope", 0.0))}
    return all(math.isclose(own[name], value, rel_tol=1e-6, abs_tol=1e-9) for name, value in place.items())


def end_keys(spec: Spec, point: Index) -> tuple[str, str]:
    """Names of the motions from and to rest at a point: one pair for every slope of the grid."""
    own = f"-{point[-1]:03d}" if spec.slope else ""
    return START + own, STOP + own


def _parsed(path: Path) -> Any:
    try:
        return parse_json(read_bounded(path, _LIMIT))
    except (ValueError, RecursionError) as error:
        raise BadInput(str(path), str(error)[:60], "a whole JSON file", _REMEDY) from None
