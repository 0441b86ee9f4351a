"""One reader for documents that a stranger wrote: cards, scenarios, motions, gaits."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class About:
    """What a number means to people: put into an annotation, it makes help texts and messages.

    Attributes:
        meaning: a phrase without a full stop.
        unit: SI; empty without one.
        metavar: what stands for the value in a command line's usage.
    """

    meaning: str
    unit: str = ""
    metavar: str = ""
