"""The package's error base: every failure a user can cause names what was wrong and what to do."""

from __future__ import annotations


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
        shown = "nothing" if value is None else repr(value)
        if len(shown) > 80:
            shown = shown[:77] + "..."
        message = f"{field}: got {shown}, expected {valid}"
        super().__init__(" ".join((message + (f"; {remedy}" if remedy else "")).split()))


class CacheRefused(GaitsmithError):
    """The folder for compiled kernels is not the owner's alone, so nothing in it may be executed."""
