"""An entry of a certificate, as the gait file has it; planner and verifier each find their own."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Worst:
    """A constraint where it is closest to its limit, or furthest beyond it.

    Attributes:
        constraint: its name.
        value: in ``unit``.
        limit: the limit that it is compared with.
        unit: of both.
        time: s from the start of the motion.
        phase: name of the phase.
        violation: share of the constraint's range; negative inside.
    """

    constraint: str
    value: float
    limit: float
    unit: str
    time: float
    phase: str
    violation: float

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return dict(vars(self))

    def __str__(self) -> str:
        return f"{self.constraint} {self.value:.4g} of {self.limit:.4g} {self.unit} in {self.phase}"
