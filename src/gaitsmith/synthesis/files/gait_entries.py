"""The entries of a gait file as types: every range, time and curve is checked before anything is computed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import AfterValidator, Field, create_model, model_validator

from gaitsmith.documents import Name, checked
from gaitsmith.errors import BadInput
from gaitsmith.robots.parameters import Parameters
from gaitsmith.synthesis.gaits.gait import CHANNELS, Gait, Piece
from gaitsmith.synthesis.motions.contacts import check_contacts, check_slope
from gaitsmith.synthesis.motions.motion import At, Condition, Limit, Motion, Phase, Same, State, Unloaded
from gaitsmith.synthesis.motions.quantities import JOINT_QUANTITIES, QUANTITIES, RATE, of_joint
from gaitsmith.synthesis.motions.settings import Bounds

Array = npt.NDArray[np.float64]
SHORTEST, LONGEST_PHASE, LONGEST = 1e-5, 60.0, 3600.0  # s
LARGEST = {"angle": 1e3, "velocity": 1e5, "acceleration": 1e8, "torque": 1e5, "wrench": 1e6}
_UNITS = {"angle": "rad", "velocity": "rad/s", "acceleration": "rad/s²", "torque": "N·m", "wrench": "N and N·m"}
CLOCK = 1e-6  # s by which times may disagree


def _quantity(name: str) -> str:
    if name not in QUANTITIES and of_joint(name) is None:
        raise ValueError(f"one of {', '.join(QUANTITIES)}, or a joint's name with .{', .'.join(JOINT_QUANTITIES)}")
    return name


def _increasing(ends: tuple[float, float]) -> tuple[float, float]:
    if not ends[0] < ends[1]:
        raise ValueError("two durations, the second one longer")
    return ends


QuantityName = Annotated[str, AfterValidator(_quantity)]
LimitName = Annotated[str, AfterValidator(lambda name: name if name == RATE else _quantity(name))]
Number = Annotated[float, Field(ge=-1e6, le=1e6)]
Amount = Annotated[float, Field(ge=-1e3, le=1e3)]  # m, m/s or the sine of an angle
Place = tuple[Amount, Amount]
Height = Annotated[float, Field(ge=-10.0, le=10.0)]  # m
Slope = Annotated[float, Field(ge=-0.5, le=0.5)]  # rad
Heading = Annotated[float, Field(ge=-1e3, le=1e3)]  # rad
_Border = Annotated[int, Field(ge=0)]
_Joints = Annotated[tuple[Number, ...], Field(max_length=200)]
_Duration = Annotated[float, Field(ge=SHORTEST, le=LONGEST_PHASE)]
DurationRange = Annotated[tuple[_Duration, _Duration], AfterValidator(_increasing)]
_Coefficient = float
_Row = Annotated[tuple[_Coefficient, ...], Field(min_length=1, max_length=200)]
_Table = Annotated[tuple[_Row, ...], Field(max_length=200)]


class Range(Parameters):
    """Bounds on a quantity, at least one of them."""

    low: Amount | None
    high: Amount | None

    @model_validator(mode="after")
    def _in_order(self) -> Range:
        if self.low is None and self.high is None:
            raise ValueError("a number for at least one of the two bounds")
        if self.low is not None and self.high is not None and self.low > self.high:
            raise ValueError("a lower bound that is not above the upper one")
        return self

    def limit(self, quantity: str, field: str) -> Limit:
        """The bounds on a quantity; one that is not given is infinite.

        Raises:
            BadInput: a torque rate with a lower bound, or with none above 0.
        """
        if quantity == RATE and (self.low is not None or not (self.high or 0.0) > 0.0):
            raise BadInput(field, f"{self.low} to {self.high}", "an upper bound above 0 alone, for both directions")
        return Limit(quantity, -np.inf if self.low is None else self.low, np.inf if self.high is None else self.high)


class _LimitEntry(Range):
    quantity: LimitName


class _Section(Parameters):
    start: Annotated[float, Field(ge=0.0, le=LONGEST + CLOCK)]
    duration: _Duration
    joints: _Table
    torque: _Table
    wrench: Annotated[tuple[_Row, ...], Field(min_length=CHANNELS, max_length=CHANNELS)]
    root: Annotated[tuple[_Row, ...], Field(max_length=6)] = ()


class _PhaseEntry(Parameters):
    name: Name
    duration: _Duration
    support: Literal["left", "right"]
    contact: Literal["air", "flat", "heel", "toe", "flight"]
    foothold: Place
    other_foothold: Place | None
    height: Height = 0.0
    other_height: Height = 0.0
    heading: Heading = 0.0
    other_heading: Heading = 0.0
    duration_range: DurationRange | None = None
    support_contact: Literal["flat", "toe"] = "flat"
    limits: Annotated[tuple[_LimitEntry, ...], Field(max_length=1000)]
    sections: Annotated[tuple[_Section, ...], Field(min_length=1, max_length=1000)]


class _Value(Parameters):
    kind: Literal["value"]
    border: _Border
    quantity: QuantityName
    value: Amount


class _State(Parameters):
    kind: Literal["state"]
    border: _Border
    position: _Joints | None
    velocity: _Joints | None
    acceleration: _Joints | None


class _Same(Parameters):
    kind: Literal["same"]
    border: _Border
    other: _Border
    mirrored: bool = False


class _Unloaded(Parameters):
    kind: Literal["unloaded"]
    border: _Border


_CONDITIONS: dict[str, type[Parameters]] = {"value": _Value, "state": _State, "same": _Same, "unloaded": _Unloaded}


class GaitEntries(Parameters):
    """A gait file, less what :mod:`gaitsmith.synthesis.files.gait_file` checks itself."""

    robot: Name
    robot_hash: Name
    motion: Name
    cyclic: bool
    total_duration: Annotated[float, Field(gt=0.0, le=LONGEST)] | None = None
    slope: Slope = 0.0
    order: Literal[4, 5]
    parameters: dict[Name, Number]
    # A default would hide what a gait was planned for.
    bounds: create_model(  # type: ignore[valid-type]
        "AllBounds",
        __base__=Bounds,
        **{name: (Annotated[(field.annotation, *field.metadata)], ...) for name, field in Bounds.model_fields.items()},
    )
    joints: Annotated[tuple[Name, ...], Field(min_length=1, max_length=200)]
    phases: Annotated[tuple[_PhaseEntry, ...], Field(min_length=1, max_length=10_000)]
    conditions: Annotated[tuple[dict[str, Any], ...], Field(max_length=20_000)]
    solver: dict[str, Any]
    certificate: dict[str, Any]


def gait_from(document: dict[str, Any]) -> Gait:
    """The gait that a document of the right format and version describes.

    Raises:
        BadInput: an entry is missing, of another type, out of range, or disagrees with the others.
    """
    entries = checked(GaitEntries, document)
    joints = entries.joints
    if len(set(joints)) != len(joints):
        raise BadInput("joints", next(name for name in joints if joints.count(name) > 1), "names that all differ")
    phases, groups, clock = [], [], 0.0
    for index, item in enumerate(entries.phases):
        groups.append(_pieces(item, f"phases[{index}].sections", clock, len(joints)))
        place = f"phases[{index}].limits"
        limits = tuple(limit.limit(limit.quantity, f"{place}[{k}]") for k, limit in enumerate(item.limits))
        for k, limit in enumerate(limits):
            _check_joint(limit.quantity, joints, f"{place}[{k}].quantity")
        where = (item.support, item.contact, item.foothold, item.other_foothold)
        more = item.height, item.other_height, item.heading, item.other_heading
        phases.append(
            Phase(
                item.name,
                item.duration,
                *where,
                len(item.sections),
                limits,
                *more,
                between=item.duration_range,
                support_contact=item.support_contact,
            )
        )
        clock += item.duration
    if clock > LONGEST:
        raise BadInput("phases", f"{clock:.6g} s", f"at most {LONGEST:g} s in all")
    check_contacts(tuple(phases), entries.cyclic, ("foothold", "other_foothold"))
    conditions = tuple(
        _condition(item, f"conditions[{index}]", len(phases), joints) for index, item in enumerate(entries.conditions)
    )
    told = entries.cyclic, entries.parameters, entries.total_duration, entries.slope
    motion = Motion(entries.motion, tuple(phases), conditions, *told)
    check_slope(motion)
    return Gait(
        robot=entries.robot,
        robot_hash=entries.robot_hash,
        joint_names=joints,
        motion=motion,
        pieces=tuple(groups),
        bounds=entries.bounds.model_dump(),
        order=entries.order,
        solver=entries.solver,
        certificate=entries.certificate,
    )


def _check_joint(quantity: str, joints: Sequence[str], field: str) -> None:
    """Refuse a quantity of a joint that is not there."""
    found = of_joint(quantity)
    if found is not None and found[0] not in joints:
        raise BadInput(field, found[0], f"one of the joints: {', '.join(joints)}")


def _condition(entry: dict[str, Any], field: str, borders: int, joints: Sequence[str]) -> Condition:
    """A condition of the kind that its entry names."""
    kind = entry.get("kind")
    if not isinstance(kind, str) or kind not in _CONDITIONS:
        raise BadInput(f"{field}.kind", kind, f"one of {', '.join(_CONDITIONS)}")
    item = checked(_CONDITIONS[kind], entry, field)
    for name in ("border", "other"):
        if getattr(item, name, 0) > borders:
            raise BadInput(f"{field}.{name}", getattr(item, name), f"a whole number from 0 to {borders}")
    if isinstance(item, _Value):
        _check_joint(item.quantity, joints, f"{field}.quantity")
        return At(item.border, item.quantity, item.value)
    if isinstance(item, _Same):
        return Same(item.border, item.other, item.mirrored)
    if isinstance(item, _Unloaded):
        return Unloaded(item.border)
    assert isinstance(item, _State)
    found: dict[str, Array | None] = {}
    for name in ("position", "velocity", "acceleration"):
        values = getattr(item, name)
        if values is not None and len(values) != len(joints):
            raise BadInput(f"{field}.{name}", f"{len(values)} numbers", f"{len(joints)}, one a joint, or null")
        found[name] = None if values is None else np.array(values, dtype=np.float64)
    return State(item.border, **found)


def _pieces(phase: _PhaseEntry, field: str, clock: float, joints: int) -> tuple[Piece, ...]:
    """The sections of a phase that begins at ``clock``, s."""
    found, start = [], clock
    for k, section in enumerate(phase.sections):
        place = f"{field}[{k}]"
        if abs(section.start - start) > CLOCK:
            raise BadInput(f"{place}.start", section.start, f"{start:.6g}, where the section before ends")
        piece = Piece(
            section.start,
            section.duration,
            _table(section.joints, joints, 3, f"{place}.joints"),
            _table(section.torque, joints, 1, f"{place}.torque"),
            _table(section.wrench, CHANNELS, 1, f"{place}.wrench"),
            _table(section.root, len(section.root), 3, f"{place}.root") if section.root else np.zeros((0, 1)),
        )
        _check_curves(piece, place)
        found.append(piece)
        start += section.duration
    if abs(start - clock - phase.duration) > CLOCK:
        raise BadInput(field, f"{start - clock:.6g} s", f"{phase.duration:.6g} s, the phase's duration")
    return tuple(found)


def _table(rows: Sequence[Sequence[float]], count: int, least: int, field: str) -> Array:
    """(count, m) numbers, at least ``least`` in every row, and equally many."""
    if len(rows) != count:
        raise BadInput(field, f"{len(rows)} rows", f"{count} rows of numbers")
    for index, row in enumerate(rows):
        if len(row) != len(rows[0]) or len(row) < least:
            valid = f"{max(len(rows[0]), least)} or more numbers, the same in every row"
            raise BadInput(f"{field}[{index}]", f"{len(row)} numbers", valid)
    return np.array(rows, dtype=np.float64)


def _check_curves(piece: Piece, field: str) -> None:
    """Curves that stay in a range in which everything computed from them is finite.

    The sum of the coefficients' sizes is an upper bound of a curve over its section, for powers and for Chebyshev
    polynomials alike.
    """
    with np.errstate(over="ignore"):
        found = [("torque", "torque", np.abs(piece.torque)), ("wrench", "wrench", np.abs(piece.wrench))]
        for key in ("joints", "root"):
            sizes = np.abs(getattr(piece, key))
            powers = np.arange(sizes.shape[1])
            rates = sizes * (powers / piece.duration), sizes * (powers * (powers - 1.0) / piece.duration**2)
            named = zip(("angle", "velocity", "acceleration"), (sizes, *rates), strict=True)
            found += [(name, key, values) for name, values in named if len(values)]
        for name, key, terms in found:
            largest = terms.sum(axis=1)
            row = int(np.argmax(largest))
            if not largest[row] <= LARGEST[name]:
                valid = f"at most {LARGEST[name]:g} {_UNITS[name]}, the sizes of its terms added"
                raise BadInput(f"{field}.{key}[{row}]: {name}", f"up to {largest[row]:.3g}", valid)
