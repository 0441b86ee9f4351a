"""Entries of a document from a stranger, read strictly: every type, range and shape is checked, and named."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput

Array = npt.NDArray[np.float64]
LONGEST = 200  # characters of a text


def number(value: object, field: str, low: float, high: float) -> float:
    """A finite number from ``low`` to ``high``, neither a boolean nor a text.

    Raises:
        BadInput: naming the field, as do all functions here.
    """
    valid = f"a number from {low:g} to {high:g}"
    if type(value) not in (int, float):
        raise BadInput(field, _short(value), valid)
    # A whole number of many digits is compared exactly; turned into a float it would overflow.
    if not low <= value <= high:  # type: ignore[operator]
        raise BadInput(field, _short(value), valid)
    return float(value)  # type: ignore[arg-type]


def integer(value: object, field: str, low: int, high: int) -> int:
    """A whole number from ``low`` to ``high``, written without a fraction."""
    valid = f"{low} or {high}" if high == low + 1 else f"a whole number from {low} to {high}"
    if type(value) is not int or not low <= value <= high:
        raise BadInput(field, _short(value), valid)
    return value


def flag(value: object, field: str) -> bool:
    """True or false."""
    if type(value) is not bool:
        raise BadInput(field, _short(value), "true or false")
    return value


def text(value: object, field: str) -> str:
    """A printable text of 1 to 200 characters."""
    if not isinstance(value, str) or not 1 <= len(value) <= LONGEST or not value.isprintable():
        raise BadInput(field, _short(value), f"a printable text of 1 to {LONGEST} characters")
    return value


def word(value: object, field: str, choices: Iterable[str]) -> Any:
    """One of the choices."""
    known = tuple(choices)
    if not isinstance(value, str) or value not in known:
        raise BadInput(field, _short(value), f"one of {', '.join(known)}")
    return value


def mapping(value: object, field: str, keys: Iterable[str] = ()) -> dict[str, Any]:
    """An object that has all of ``keys``."""
    if not isinstance(value, dict):
        raise BadInput(field or "content", _short(value), "an object")
    for key in keys:
        if key not in value:
            raise BadInput(f"{field}.{key}" if field else key, None, "an entry")
    return value


def sequence(value: object, field: str, least: int, most: int) -> list[Any]:
    """A list of ``least`` to ``most`` entries."""
    if not isinstance(value, list) or not least <= len(value) <= most:
        shown = f"{len(value)} entries" if isinstance(value, list) else _short(value)
        raise BadInput(field, shown, f"a list of {least} to {most} entries")
    return value


def pair(value: object, field: str, limit: float) -> tuple[float, float]:
    """Two numbers of at most ``limit``."""
    if not isinstance(value, list) or len(value) != 2:
        raise BadInput(field, _short(value), "two numbers")
    return number(value[0], f"{field}[0]", -limit, limit), number(value[1], f"{field}[1]", -limit, limit)


def table(value: object, rows: int, least: int, most: int, field: str) -> Array:
    """(rows, m) finite numbers, the same number of columns in every row, ``least`` to ``most``."""
    if not isinstance(value, list) or len(value) != rows:
        shown = f"{len(value)} rows" if isinstance(value, list) else _short(value)
        raise BadInput(field, shown, f"{rows} rows of numbers")
    columns = len(value[0]) if isinstance(value[0], list) else 0
    for index, row in enumerate(value):
        if not isinstance(row, list) or not least <= len(row) <= most:
            shown = f"{len(row)} numbers" if isinstance(row, list) else _short(row)
            raise BadInput(f"{field}[{index}]", shown, f"a row of {least} to {most} numbers")
        if len(row) != columns:
            raise BadInput(f"{field}[{index}]", f"{len(row)} numbers", f"{columns}, as in the first row")
        if not {int, float}.issuperset(map(type, row)):
            _refuse_row(row, f"{field}[{index}]")
    try:
        found = np.array(value, dtype=np.float64)
    except OverflowError:
        raise BadInput(field, "a number beyond 1e308", "finite numbers") from None
    if not np.isfinite(found).all():
        raise BadInput(field, "a number that is not finite", "finite numbers")
    return found


def _refuse_row(row: list[Any], field: str) -> NoReturn:
    column = next(k for k, item in enumerate(row) if type(item) not in (int, float))
    raise BadInput(f"{field}[{column}]", _short(row[column]), "a number")


def _short(value: object) -> object:
    """The value, or what stands for one that is too long to be written: repr refuses whole numbers of many digits."""
    if type(value) is int and value.bit_length() > 200:
        return f"about 1e{int(value.bit_length() * math.log10(2.0))}"
    if isinstance(value, (dict, list)):
        return f"{type(value).__name__} of {len(value)} entries"
    return value
