"""A gait from the entries of its file: every type, range, time and curve is checked before anything is computed."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import ValidationError

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.gaits.entries import flag, integer, mapping, number, pair, sequence, table, text, word
from gaitsmith.synthesis.gaits.gait import CHANNELS, Gait, Piece
from gaitsmith.synthesis.motions.contacts import check_contacts
from gaitsmith.synthesis.motions.motion import QUANTITIES, At, Limit, Motion, Phase
from gaitsmith.synthesis.motions.settings import Bounds

Array = npt.NDArray[np.float64]
JOINTS = 200
PHASES, SECTIONS = 10_000, 1_000  # of a motion, of a phase
COEFFICIENTS = 200
SHORTEST, LONGEST_PHASE, LONGEST = 1e-5, 60.0, 3600.0  # s
FURTHEST = 1e3  # m, of a foothold
LARGEST = {"angle": 1e3, "velocity": 1e5, "acceleration": 1e8, "torque": 1e5, "wrench": 1e6}
_UNITS = {"angle": "rad", "velocity": "rad/s", "acceleration": "rad/s²", "torque": "N·m", "wrench": "N and N·m"}
_PARAMETER = 1e6
_CLOCK = 1e-6  # s by which times may disagree
_KEYS = (
    "robot",
    "robot_hash",
    "motion",
    "cyclic",
    "order",
    "parameters",
    "bounds",
    "joints",
    "phases",
    "conditions",
    "solver",
    "certificate",
)
_PHASE_KEYS = (
    "name",
    "duration",
    "support",
    "contact",
    "foothold",
    "other_foothold",
    "limits",
    "sections",
)


def gait_from(document: dict[str, Any]) -> Gait:
    """The gait that a document of the right format and version describes.

    Raises:
        BadInput: an entry is missing, of another type, out of range, or disagrees with the others.
    """
    mapping(document, "", _KEYS)
    names = tuple(
        text(name, f"joints[{k}]") for k, name in enumerate(sequence(document["joints"], "joints", 1, JOINTS))
    )
    if len(set(names)) != len(names):
        raise BadInput("joints", next(name for name in names if names.count(name) > 1), "names that all differ")
    phases, groups, clock = [], [], 0.0
    for index, item in enumerate(sequence(document["phases"], "phases", 1, PHASES)):
        phase, pieces = _phase(item, f"phases[{index}]", clock, len(names))
        phases.append(phase)
        groups.append(pieces)
        clock += phase.duration
    if clock > LONGEST:
        raise BadInput("phases", f"{clock:.6g} s", f"at most {LONGEST:g} s in all")
    cyclic = flag(document["cyclic"], "cyclic")
    check_contacts(tuple(phases), cyclic, ("foothold", "other_foothold"))
    parameters = mapping(document["parameters"], "parameters")
    return Gait(
        robot=text(document["robot"], "robot"),
        robot_hash=text(document["robot_hash"], "robot_hash"),
        joint_names=names,
        motion=Motion(
            text(document["motion"], "motion"),
            tuple(phases),
            _conditions(document["conditions"], len(phases)),
            cyclic,
            {key: number(value, f"parameters.{key}", -_PARAMETER, _PARAMETER) for key, value in parameters.items()},
        ),
        pieces=tuple(groups),
        bounds=_bounds(document["bounds"]),
        order=integer(document["order"], "order", 4, 5),
        solver=mapping(document["solver"], "solver"),
        certificate=mapping(document["certificate"], "certificate"),
    )


def _phase(item: object, field: str, clock: float, joints: int) -> tuple[Phase, tuple[Piece, ...]]:
    """One phase that begins at ``clock``, and its sections."""
    item = mapping(item, field, _PHASE_KEYS)
    duration = number(item["duration"], f"{field}.duration", SHORTEST, LONGEST_PHASE)
    other = item["other_foothold"]
    pieces, start = [], clock
    for k, section in enumerate(sequence(item["sections"], f"{field}.sections", 1, SECTIONS)):
        pieces.append(_piece(section, f"{field}.sections[{k}]", start, joints))
        start += pieces[-1].duration
    if abs(start - clock - duration) > _CLOCK:
        raise BadInput(f"{field}.sections", f"{start - clock:.6g} s", f"{duration:.6g} s, the phase's duration")
    phase = Phase(
        name=text(item["name"], f"{field}.name"),
        duration=duration,
        support=word(item["support"], f"{field}.support", ("left", "right")),
        contact=word(item["contact"], f"{field}.contact", ("air", "flat", "heel", "toe")),
        foothold=pair(item["foothold"], f"{field}.foothold", FURTHEST),
        other=None if other is None else pair(other, f"{field}.other_foothold", FURTHEST),
        sections=len(pieces),
        limits=_limits(item["limits"], f"{field}.limits"),
    )
    return phase, tuple(pieces)


def _piece(section: object, field: str, start: float, joints: int) -> Piece:
    section = mapping(section, field, ("start", "duration", "joints", "torque", "wrench"))
    given = number(section["start"], f"{field}.start", 0.0, LONGEST + _CLOCK)
    if abs(given - start) > _CLOCK:
        raise BadInput(f"{field}.start", given, f"{start:.6g}, where the section before ends")
    piece = Piece(
        given,
        number(section["duration"], f"{field}.duration", SHORTEST, LONGEST_PHASE),
        table(section["joints"], joints, 3, COEFFICIENTS, f"{field}.joints"),
        table(section["torque"], joints, 1, COEFFICIENTS, f"{field}.torque"),
        table(section["wrench"], CHANNELS, 1, COEFFICIENTS, f"{field}.wrench"),
    )
    _check_curves(piece, field)
    return piece


def _check_curves(piece: Piece, field: str) -> None:
    """Curves that stay in a range in which everything computed from them is finite.

    The sum of the coefficients' sizes is an upper bound of a curve over its section, for powers and for Chebyshev
    polynomials alike.
    """
    powers = np.arange(piece.joints.shape[1])
    with np.errstate(over="ignore"):
        sizes = np.abs(piece.joints)
        found = {
            "angle": ("joints", sizes),
            "velocity": ("joints", sizes * (powers / piece.duration)),
            "acceleration": ("joints", sizes * (powers * (powers - 1.0) / piece.duration**2)),
            "torque": ("torque", np.abs(piece.torque)),
            "wrench": ("wrench", np.abs(piece.wrench)),
        }
        for name, (key, terms) in found.items():
            largest = terms.sum(axis=1)
            row = int(np.argmax(largest))
            if not largest[row] <= LARGEST[name]:
                valid = f"at most {LARGEST[name]:g} {_UNITS[name]}, the sizes of its terms added"
                raise BadInput(f"{field}.{key}[{row}]: {name}", f"up to {largest[row]:.3g}", valid)


def _limits(value: object, field: str) -> tuple[Limit, ...]:
    found = []
    for k, entry in enumerate(sequence(value, field, 0, len(QUANTITIES))):
        place = f"{field}[{k}]"
        item = mapping(entry, place, ("quantity", "low", "high"))
        low, high = (
            None if item[key] is None else number(item[key], f"{place}.{key}", -FURTHEST, FURTHEST)
            for key in ("low", "high")
        )
        if low is None and high is None:
            raise BadInput(place, "neither low nor high", "a number for at least one of them")
        if low is not None and high is not None and low > high:
            raise BadInput(place, f"low {low:g} and high {high:g}", "low that is not above high")
        quantity = word(item["quantity"], f"{place}.quantity", QUANTITIES)
        found.append(Limit(quantity, -np.inf if low is None else low, np.inf if high is None else high))
    return tuple(found)


def _conditions(value: object, phases: int) -> tuple[At, ...]:
    found = []
    for k, entry in enumerate(sequence(value, "conditions", 0, 100 * PHASES)):
        place = f"conditions[{k}]"
        item = mapping(entry, place, ("border", "quantity", "value"))
        border = integer(item["border"], f"{place}.border", 0, phases)
        quantity = word(item["quantity"], f"{place}.quantity", QUANTITIES)
        found.append(At(border, quantity, number(item["value"], f"{place}.value", -FURTHEST, FURTHEST)))
    return tuple(found)


def _bounds(value: object) -> dict[str, float]:
    """Bounds as numbers, all of them given: a default would hide what a gait was planned for."""
    known = Bounds.model_fields
    given = mapping(value, "bounds", known)
    for key in given:
        if key not in known:
            raise BadInput(f"bounds.{key}", given[key], f"one of {', '.join(known)}")
    found = {key: number(given[key], f"bounds.{key}", 0.0, 100.0) for key in known}
    try:
        Bounds.model_validate(found)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        key = str(first["loc"][0])
        raise BadInput(f"bounds.{key}", found[key], first["msg"].removeprefix("Input should be ")) from None
    return found
