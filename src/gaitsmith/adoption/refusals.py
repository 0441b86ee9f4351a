"""Why a model is not adopted: no card makes it a biped, or the user has to say what cannot be inferred."""

from __future__ import annotations

from collections.abc import Iterable

from gaitsmith.errors import BadInput

WALKABLE = "two legs, each one open chain of 3 to 12 joints with pitch at hip, knee and ankle, and a flat or line sole"
_SHOWN = 8  # candidates at most


class Unfit(BadInput):
    """A model that no card makes a biped; the sentence says what can walk."""

    def __init__(self, entry: str, found: str, remedy: str = "") -> None:
        super().__init__(entry, found, f"a robot this package can walk: {WALKABLE}", remedy)


class Asked(BadInput):
    """What has to be said with a flag.

    Attributes:
        candidates: values that it could have, the likeliest first.
    """

    def __init__(
        self, flag: str, candidates: Iterable[str], field: str, value: object, valid: str, remedy: str = ""
    ) -> None:
        super().__init__(field, value, valid, remedy)
        self.flag = flag
        self.candidates = [candidate for candidate in candidates if candidate][:_SHOWN]

    def document(self) -> dict[str, object]:
        """As the JSON contract has it."""
        return {"flag": self.flag, "candidates": self.candidates}


def unsure_of_feet(entry: str, found: str, feet: Iterable[str]) -> Asked:
    """Several limbs could be the two legs; ``feet`` in pairs."""
    names = list(feet)
    valid = "two legs; several limbs could be them"
    return Asked("--feet", names, entry, found, valid, f"say which: --feet {names[0]} --feet {names[1]}")
