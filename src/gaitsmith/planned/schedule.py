"""Contact phases in a row, and what ends each of them: one type for gaits, motions and the gait template."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from gaitsmith.errors import BadInput
from gaitsmith.whole_body.reference import FLAT, HEEL, NONE, TOE

BY_CLOCK = 0
"""A phase ends when its time is over."""
BY_CONTACT = 1
"""A phase ends when a swinging sole meets the ground: earlier than planned, or later, within bounds."""

_KINDS = {NONE: "none", FLAT: "flat", HEEL: "heel", TOE: "toe"}


@dataclass(frozen=True)
class ContactPhase:
    """A stretch of time with one set of contacts.

    Attributes:
        name: what reports call it.
        duration: s.
        support: row of the sole that stands throughout, flat or on its toe's edge, or stood before a flight; positions
            are relative to it.
        contact: kind of every sole's contact: NONE, FLAT, HEEL or TOE.
        end: BY_CLOCK or BY_CONTACT.
    """

    name: str
    duration: float
    support: int
    contact: tuple[int, ...]
    end: int = BY_CLOCK

    @property
    def bearing(self) -> tuple[bool, ...]:
        """Whether each sole is on the ground."""
        return tuple(kind != NONE for kind in self.contact)


@dataclass(frozen=True)
class Schedule:
    """Phases in order of time.

    Attributes:
        phases: at least one.
        cyclic: whether the first phase follows the last one.

    Raises:
        BadInput: phases that contradict their contacts, naming the entry as in ``phases[2].support``.
    """

    phases: tuple[ContactPhase, ...]
    cyclic: bool = False

    def __post_init__(self) -> None:
        if not self.phases:
            raise BadInput("phases", (), "at least one phase")
        for index, phase in enumerate(self.phases):
            _check_phase(phase, f"phases[{index}]", len(self.phases[0].contact))
        pairs = [*pairwise(enumerate(self.phases))]
        if self.cyclic:
            pairs.append(((len(self.phases) - 1, self.phases[-1]), (0, self.phases[0])))
        for (before, earlier), (index, later) in pairs:
            _check_pair(earlier, later, f"phases[{before}]", f"phases[{index}]")
        if self.phases[-1].end == BY_CONTACT and not self.cyclic:
            raise BadInput(f"phases[{len(self.phases) - 1}].end", "by contact", "a phase after it with the sole down")


def _lands(before: ContactPhase, after: ContactPhase) -> bool:
    return any(not a and b for a, b in zip(before.bearing, after.bearing, strict=True))


def _check_phase(phase: ContactPhase, field: str, soles: int) -> None:
    if not 0.0 < phase.duration < float("inf"):
        raise BadInput(f"{field}.duration", phase.duration, "a positive number of seconds")
    if len(phase.contact) != soles:
        raise BadInput(f"{field}.contact", phase.contact, f"{soles} kinds, one a sole")
    for given in phase.contact:
        if given not in _KINDS:
            raise BadInput(f"{field}.contact", given, ", ".join(f"{key} ({name})" for key, name in _KINDS.items()))
    if not 0 <= phase.support < soles:
        raise BadInput(f"{field}.support", phase.support, f"0 to {soles - 1}")
    if any(phase.bearing) and phase.contact[phase.support] not in (FLAT, TOE):
        kind = _KINDS[phase.contact[phase.support]]
        raise BadInput(
            f"{field}.support", phase.support, "a sole that stands flat or on its toe", f"its contact is {kind}"
        )
    if phase.end not in (BY_CLOCK, BY_CONTACT):
        raise BadInput(f"{field}.end", phase.end, f"{BY_CLOCK} (by clock) or {BY_CONTACT} (by contact)")
    if phase.end == BY_CONTACT and all(phase.bearing):
        raise BadInput(f"{field}.end", "by contact", "by clock", "no sole is in the air that could meet the ground")


def _check_pair(before: ContactPhase, after: ContactPhase, earlier: str, later: str) -> None:
    if any(after.bearing) and not before.bearing[after.support] and before.end != BY_CONTACT:
        remedy = f"it is in the air in {earlier}, which ends by the clock"
        raise BadInput(f"{later}.support", after.support, "a sole that is on the ground before", remedy)
    if before.end == BY_CONTACT and not _lands(before, after):
        raise BadInput(f"{earlier}.end", "by contact", "by clock", f"no sole lands between it and {later}")
    for sole, (one, two) in enumerate(zip(before.contact, after.contact, strict=True)):
        if {one, two} == {HEEL, TOE}:
            field, got = f"{later}.contact[{sole}]", f"{_KINDS[one]} then {_KINDS[two]}"
            raise BadInput(field, got, "flat in between", "a sole does not jump from edge to edge")
