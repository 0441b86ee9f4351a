"""The gait file: versioned JSON, written whole or not at all, with a checksum that shows edits."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded, write_text_atomic
from gaitsmith.robots import Robot, load_robot, robot_names
from gaitsmith.synthesis.gait import CHANNELS, Gait, Piece
from gaitsmith.synthesis.motion import QUANTITIES, At, Limit, Motion, Phase

FORMAT = "gaitsmith-gait"
VERSION = 1
LIMIT = 50_000_000
_REMEDY = "plan it again"
Array = npt.NDArray[np.float64]


def _finite_or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def gait_document(gait: Gait) -> dict[str, Any]:
    """The gait as plain data, checksum included."""
    phases = []
    for phase, pieces in zip(gait.motion.phases, gait.pieces, strict=True):
        phases.append(
            {
                "name": phase.name,
                "duration": phase.duration,
                "support": phase.support,
                "contact": phase.contact,
                "foothold": list(phase.foothold),
                "other_foothold": None if phase.other is None else list(phase.other),
                "limits": [
                    {"quantity": item.quantity, "low": _finite_or_none(item.low), "high": _finite_or_none(item.high)}
                    for item in phase.limits
                ],
                "sections": [
                    {
                        "start": piece.start,
                        "duration": piece.duration,
                        "joints": piece.joints.tolist(),
                        "torque": piece.torque.tolist(),
                        "wrench": piece.wrench.tolist(),
                    }
                    for piece in pieces
                ],
            }
        )
    conditions = [
        {"border": item.border, "quantity": item.quantity, "value": item.value}
        for item in gait.motion.conditions
        if isinstance(item, At)
    ]
    document: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "robot": gait.robot,
        "robot_hash": gait.robot_hash,
        "motion": gait.motion.name,
        "cyclic": gait.motion.cyclic,
        "order": gait.order,
        "parameters": gait.motion.parameters,
        "bounds": gait.bounds,
        "joints": list(gait.joint_names),
        "phases": phases,
        "conditions": conditions,
        "solver": gait.solver,
        "certificate": gait.certificate,
    }
    document["checksum"] = _checksum(document)
    return document


def _checksum(document: dict[str, Any]) -> str:
    kept = {key: value for key, value in document.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(kept, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def write_gait(path: str | Path, gait: Gait) -> None:
    """Write a gait file, whole or not at all.

    Raises:
        BadInput: the folder is missing or cannot be written.
    """
    write_text_atomic(path, json.dumps(gait_document(gait), separators=(",", ":")) + "\n")


def _refuse_constant(word: str) -> NoReturn:
    raise ValueError(f"the number {word}")


def read_gait(path: str | Path, allow_edited: bool = False) -> tuple[Gait, bool]:
    """A gait from a file, and whether its checksum holds.

    Args:
        path: the file.
        allow_edited: hand back a well-formed file whose checksum does not hold, instead of refusing it.

    Raises:
        BadInput: missing, larger than 50 MB, truncated, of another format or version, edited, or malformed.
    """
    shown = str(path)
    try:
        document = json.loads(read_bounded(path, LIMIT).decode("utf-8"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise BadInput(shown, str(error)[:60], "a whole gait file in JSON", _REMEDY) from None
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        given = document.get("format") if isinstance(document, dict) else type(document).__name__
        raise BadInput(f"{shown}: format", given, FORMAT, "give a file that gaitsmith plan wrote")
    if document.get("version") != VERSION:
        raise BadInput(f"{shown}: version", document.get("version"), str(VERSION), _REMEDY)
    intact = document.get("checksum") == _checksum(document)
    if not intact and not allow_edited:
        raise BadInput(f"{shown}: checksum", document.get("checksum"), "the content's own", f"edited; {_REMEDY}")
    try:
        return _parse(document), intact
    except BadInput as error:
        raise BadInput(f"{shown}: {error.field}", error.value, error.valid, _REMEDY) from None
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        detail = f"{type(error).__name__}: {error}"
        raise BadInput(shown, detail, "the entries of a gait file", _REMEDY) from None


def require_robot(gait: Gait, robot: Robot) -> None:
    """A gait is for one robot only.

    Raises:
        BadInput: another robot, or one whose files have changed since.
    """
    if gait.robot_hash != robot.content_hash or gait.joint_names != robot.joint_names:
        valid = f"a gait for {robot.card.name} with hash {robot.content_hash[:12]}"
        raise BadInput("robot", f"{gait.robot} {gait.robot_hash[:12]}", valid, "give --robot, or plan again")


def load_robot_of(gait: Gait, name_or_path: str | None = None) -> Robot:
    """The robot that a gait was planned for, checked by its hash.

    Args:
        gait: the gait.
        name_or_path: where the robot is, if it is not one of the package.

    Raises:
        BadInput: it cannot be found, or is another one, or has changed since.
    """
    if name_or_path is None and gait.robot not in robot_names():
        raise BadInput("--robot", None, f"the card of {gait.robot[:60]}", "the gait is for a robot of your own")
    robot = load_robot(name_or_path or gait.robot)
    require_robot(gait, robot)
    return robot


def _number(value: Any, field: str, low: float = -np.inf, high: float = np.inf) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise BadInput(field, value, "a finite number")
    if not low <= value <= high:
        raise BadInput(field, value, f"{low:g} to {high:g}")
    return float(value)


def _word(value: Any, field: str, choices: tuple[str, ...]) -> Any:
    if value not in choices:
        raise BadInput(field, value, f"one of {', '.join(choices)}")
    return value


def _pair(value: Any, field: str) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise BadInput(field, value, "two numbers")
    return _number(value[0], field, -1e3, 1e3), _number(value[1], field, -1e3, 1e3)


def _table(value: Any, rows: int, field: str) -> Array:
    table = np.array(value, dtype=np.float64)
    if table.ndim != 2 or table.shape[0] != rows or not 1 <= table.shape[1] <= 200 or not np.isfinite(table).all():
        raise BadInput(field, f"shape {table.shape}", f"{rows} rows of finite numbers")
    return table


def _parse(document: dict[str, Any]) -> Gait:
    names = tuple(str(name) for name in document["joints"])
    phases, groups, clock = [], [], 0.0
    if not document["phases"] or len(document["phases"]) > 10_000:
        raise BadInput("phases", len(document["phases"]), "1 to 10000 phases")
    for index, item in enumerate(document["phases"]):
        field = f"phases[{index}]"
        duration = _number(item["duration"], f"{field}.duration", 1e-4, 1e4)
        other = item["other_foothold"]
        contact = _word(item["contact"], f"{field}.contact", ("air", "flat", "heel", "toe"))
        if (other is None) != (contact == "air"):
            raise BadInput(f"{field}.other_foothold", other, "two numbers, or null in the air")
        limits = tuple(
            Limit(
                _word(limit["quantity"], f"{field}.limits", QUANTITIES),
                -np.inf if limit["low"] is None else _number(limit["low"], f"{field}.limits"),
                np.inf if limit["high"] is None else _number(limit["high"], f"{field}.limits"),
            )
            for limit in item["limits"]
        )
        pieces, start = [], clock
        for k, section in enumerate(item["sections"]):
            place = f"{field}.sections[{k}]"
            span = _number(section["duration"], f"{place}.duration", 1e-6, 1e4)
            given = _number(section["start"], f"{place}.start")
            if abs(given - start) > 1e-6:
                raise BadInput(f"{place}.start", given, f"{start:.6g}, where the section before ends")
            joints = _table(section["joints"], len(names), f"{place}.joints")
            if joints.shape[1] < 3:
                raise BadInput(f"{place}.joints", f"shape {joints.shape}", "at least 3 coefficients a joint")
            torque = _table(section["torque"], len(names), f"{place}.torque")
            pieces.append(Piece(given, span, joints, torque, _table(section["wrench"], CHANNELS, f"{place}.wrench")))
            start += span
        if not pieces or abs(start - clock - duration) > 1e-6:
            raise BadInput(f"{field}.sections", f"{start - clock:.6g} s", f"{duration:.6g} s, the phase's duration")
        clock += duration
        phases.append(
            Phase(
                name=str(item["name"])[:100],
                duration=duration,
                support=_word(item["support"], f"{field}.support", ("left", "right")),
                contact=contact,
                foothold=_pair(item["foothold"], f"{field}.foothold"),
                other=None if other is None else _pair(other, f"{field}.other_foothold"),
                sections=len(pieces),
                limits=limits,
            )
        )
        groups.append(tuple(pieces))
    conditions = tuple(
        At(
            int(_number(c["border"], "conditions", 0, len(phases))),
            str(c["quantity"]),
            _number(c["value"], "conditions"),
        )
        for c in document["conditions"]
    )
    parameters = {str(key): _number(value, f"parameters.{key}") for key, value in document["parameters"].items()}
    bounds = {str(key): _number(value, f"bounds.{key}") for key, value in document["bounds"].items()}
    motion = Motion(str(document["motion"]), tuple(phases), conditions, bool(document["cyclic"]), parameters)
    return Gait(
        robot=str(document["robot"]),
        robot_hash=str(document["robot_hash"]),
        joint_names=names,
        motion=motion,
        pieces=tuple(groups),
        bounds=bounds,
        order=int(_number(document["order"], "order", 4, 5)),
        solver=dict(document["solver"]),
        certificate=dict(document["certificate"]),
    )
