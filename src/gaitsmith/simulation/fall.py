"""A fall, and why."""

from __future__ import annotations

from gaitsmith.documents import Frozen


class Cause(Frozen):
    """Why a robot fell.

    Attributes:
        what: in words.
        confirmed: whether it stands in the same run without that; None as long as nobody has tried
            (``gaitsmith why``).
    """

    what: str
    confirmed: bool | None = None


class Fall(Frozen):
    """A fall.

    Attributes:
        time: s since the beginning of the run.
        phase: stance leg and share of the step, in words.
        reason: how it fell, then the limits hit since the last step without any, first one first.
        cause: what most likely began it.
    """

    time: float
    phase: str
    reason: str
    cause: Cause | None = None
