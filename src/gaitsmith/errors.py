"""The package's error base: every failure a user can cause names what was wrong and what to do."""

from __future__ import annotations

import reprlib

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 100


_LONGEST = 400  # characters of a message


class GaitsmithError(Exception):
    """Base of all errors raised on purpose by this package."""


class BadInput(GaitsmithError):
    """A file, card, scenario, or argument that cannot be used; the command line exits with code 2.

    Args:
        field: what was wrong, named as the user wrote it (``"--height"``, ``"card.toml: legs[0].sole.toe"``).
        value: the value that was given; None if there was none.
        valid: the valid range or the valid choices, in words.
        remedy: what to do about it, in words; empty if the valid range says it all.
    """

    def __init__(self, field: str, value: object, valid: str, remedy: str = "") -> None:
        self.field = field
        self.value = value
        self.valid = valid
        self.remedy = remedy
        where, shown, advice = _cut(field, 120), _shown(value), f"; {_cut(remedy, 120)}" if remedy else ""
        room = _LONGEST - len(f"{where}: got {shown}, expected {advice}")
        super().__init__(" ".join(f"{where}: got {shown}, expected {_cut(valid, room)}{advice}".split()))

    def __reduce__(self) -> tuple[type[BadInput], tuple[str, object, str, str]]:
        """To another process by what it was made of; a value that may not go there, as its words."""
        value = self.value if isinstance(self.value, str | int | float | bool | None) else _shown(self.value)
        return BadInput, (self.field, value, self.valid, self.remedy)

    def within(self, source: str) -> BadInput:
        """The same error, its field found in a source, such as a file; an empty source changes nothing."""
        return self.named(": ".join(part for part in (source, self.field) if part) or "input")

    def named(self, field: str) -> BadInput:
        """The same error, its field named as the user wrote it."""
        return BadInput(field, self.value, self.valid, self.remedy)


def _shown(value: object) -> str:
    """The value in at most 80 characters; whole numbers of many digits cannot be written out."""
    if value is None:
        return "nothing"
    if type(value) is int and value.bit_length() > 200:
        return f"a whole number of about {int(value.bit_length() * 0.30103)} digits"
    try:
        return _cut(_REPR.repr(value), 80)
    except ValueError:
        return f"a {type(value).__name__}"


def _cut(text: str, most: int) -> str:
    """The text, its middle left out where it is too long."""
    half = (most - 3) // 2
    return text if len(text) <= most else f"{text[:half]}...{text[-half:]}"


class CacheRefused(GaitsmithError):
    """The folder for compiled kernels is not the owner's alone, so nothing in it may be executed."""
