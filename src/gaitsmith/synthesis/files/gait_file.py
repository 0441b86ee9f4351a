"""The gait file: versioned JSON, written whole or not at all, with a checksum that shows edits."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gaitsmith.documents import parse_json
from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded, write_text_atomic
from gaitsmith.robots import Robot, load_robot, robot_names
from gaitsmith.synthesis.files.gait_entries import gait_from
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.motions.motion import At, Condition, Same, State

FORMAT = "gaitsmith-gait"
VERSION = 2
LIMIT = 50_000_000
_REMEDY = "plan it again"


def _finite_or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def gait_document(gait: Gait) -> dict[str, Any]:
    """The gait as plain data, checksum included."""
    phases = [
        {
            **{name: getattr(phase, name) for name in ("name", "duration", "support", "contact", "foothold")},
            "other_foothold": phase.other,
            **{name: getattr(phase, name) for name in ("height", "other_height", "heading", "other_heading")},
            **({"support_contact": phase.support_contact} if phase.tips else {}),
            **({} if phase.between is None else {"duration_range": phase.between}),
            "limits": [
                {"quantity": item.quantity, "low": _finite_or_none(item.low), "high": _finite_or_none(item.high)}
                for item in phase.limits
            ],
            "sections": [
                {"start": piece.start, "duration": piece.duration}
                | {name: getattr(piece, name).tolist() for name in ("joints", "torque", "wrench")}
                | ({"root": piece.root.tolist()} if len(piece.root) else {})
                for piece in pieces
            ],
        }
        for phase, pieces in zip(gait.motion.phases, gait.pieces, strict=True)
    ]
    document: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "robot": gait.robot,
        "robot_hash": gait.robot_hash,
        "motion": gait.motion.name,
        "cyclic": gait.motion.cyclic,
        **({"slope": gait.motion.slope} if gait.motion.slope else {}),
        **({} if gait.motion.total is None else {"total_duration": gait.motion.total}),
        "order": gait.order,
        "parameters": gait.motion.parameters,
        "bounds": gait.bounds,
        "joints": list(gait.joint_names),
        "phases": phases,
        "conditions": [condition_entry(item) for item in gait.motion.conditions],
        "solver": gait.solver,
        "certificate": gait.certificate,
    }
    document["checksum"] = _checksum(document)
    return document


def condition_entry(item: Condition) -> dict[str, Any]:
    """A condition as plain data."""
    if isinstance(item, At):
        return {"kind": "value", **vars(item)}
    if isinstance(item, State):
        given = {name: value for name, value in vars(item).items() if name != "border"}
        return {"kind": "state", "border": item.border} | {
            name: None if value is None else np.asarray(value).tolist() for name, value in given.items()
        }
    return {"kind": "same" if isinstance(item, Same) else "unloaded", **vars(item)}


def claims_hash(gait: Gait) -> str:
    """SHA-256 of all that a gait says besides its curves: phases, limits, conditions, bounds, parameters, joints."""
    document = gait_document(replace(gait, pieces=tuple(() for _ in gait.pieces), solver={}, certificate={}))
    return _checksum(json.loads(json.dumps(document), parse_int=float))  # a 0 that is read is a 0.0


def _checksum(document: dict[str, Any]) -> str:
    kept = {key: value for key, value in document.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(kept, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def write_gait(path: str | Path, gait: Gait) -> None:
    """Write a gait file, whole or not at all.

    Raises:
        BadInput: the folder is missing or cannot be written.
    """
    write_text_atomic(path, json.dumps(gait_document(gait), separators=(",", ":")) + "\n")


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
        document = parse_json(read_bounded(path, LIMIT))
    except (ValueError, RecursionError) as error:
        raise BadInput(shown, str(error)[:60], "a whole gait file in JSON", _REMEDY) from None
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        given = document.get("format") if isinstance(document, dict) else type(document).__name__
        raise BadInput(f"{shown}: format", given, FORMAT, "give a file that gaitsmith plan wrote")
    if type(document.get("version")) is not int or document["version"] != VERSION:
        raise BadInput(f"{shown}: version", document.get("version"), str(VERSION), _REMEDY)
    try:
        intact = document.get("checksum") == _checksum(document)
    except RecursionError:
        raise BadInput(shown, "deeply nested entries", "a gait file", _REMEDY) from None
    if not intact and not allow_edited:
        raise BadInput(f"{shown}: checksum", document.get("checksum"), "the content's own", f"edited; {_REMEDY}")
    try:
        return gait_of(document), intact
    except BadInput as error:
        raise BadInput(error.field, error.value, error.valid, error.remedy or _REMEDY).within(shown) from None


def gait_of(document: dict[str, Any]) -> Gait:
    """The gait in a file's document.

    Raises:
        BadInput: as :func:`gait_from`.
    """
    return gait_from({key: value for key, value in document.items() if key not in ("format", "version", "checksum")})


def require_robot(gait: Gait, robot: Robot) -> None:
    """A gait is for one robot only.

    Raises:
        BadInput: another robot, or one whose files have changed since.
    """
    if gait.robot_hash != robot.content_hash:
        valid = f"a gait for {robot.card.name} with hash {robot.content_hash[:12]}"
        remedy = "give --robot, or plan again: the robot's files have changed since, or are another robot's"
        raise BadInput("robot", f"{gait.robot} with hash {gait.robot_hash[:12]}", valid, remedy)
    for index, (phase, group) in enumerate(zip(gait.motion.phases, gait.pieces, strict=True)):
        wanted = 6 if phase.flies or phase.tips else int(robot.legs[0].sole.kind == "line")
        for k, piece in enumerate(group):
            if len(piece.root) != wanted:
                valid = f"{wanted} for this robot's soles"
                raise BadInput(f"phases[{index}].sections[{k}].root", f"{len(piece.root)} rows", valid)
    if len(gait.joint_names) != len(robot.joint_names):
        raise BadInput("joints", f"{len(gait.joint_names)} names", f"the {len(robot.joint_names)} of {robot.card.name}")
    for index, (given, own) in enumerate(zip(gait.joint_names, robot.joint_names, strict=True)):
        if given != own:
            raise BadInput(f"joints[{index}]", given, f"{own}, as in the order of {robot.card.name}", "plan again")


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
