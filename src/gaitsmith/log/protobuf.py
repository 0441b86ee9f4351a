"""Protocol Buffers messages of a fixed size, whose numbers are filled in for many messages at once.

Every field is written, zeros too, and a time takes ten bytes whatever it is, so that the place of a number does not
depend on any value. Readers of the format take such messages as any others.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Stamps = npt.NDArray[np.uint64]
Bytes = npt.NDArray[np.uint8]
_VARINT, _DOUBLE, _BYTES, _FIXED = 0, 1, 2, 5  # wire types
_DIGITS = 5  # bytes of a padded number: 35 bits
_SECOND = 10**9  # ns


class Form(NamedTuple):
    """A message, or some of its fields.

    Attributes:
        content: as it is written, numbers that are filled in as zeros.
        places: offset and column of every number that is filled in.
        stamps: offsets of the times that are filled in.
    """

    content: bytes
    places: tuple[tuple[int, int], ...] = ()
    stamps: tuple[int, ...] = ()


def joined(*forms: Form) -> Form:
    """Fields, one after the other."""
    content, places, stamps = b"", list[tuple[int, int]](), list[int]()
    for form in forms:
        places += [(len(content) + offset, column) for offset, column in form.places]
        stamps += [len(content) + offset for offset in form.stamps]
        content += form.content
    return Form(content, tuple(places), tuple(stamps))


def message(field: int, *forms: Form) -> Form:
    """A message as field of another one."""
    inner = joined(*forms)
    return joined(Form(_varint(field << 3 | _BYTES) + _varint(len(inner.content))), inner)


def text(field: int, words: str) -> Form:
    """A text as field."""
    return raw(field, words.encode())


def raw(field: int, content: bytes) -> Form:
    """Bytes, or packed numbers of a fixed size, as field."""
    return Form(_varint(field << 3 | _BYTES) + _varint(len(content)) + content)


def flag(field: int) -> Form:
    """A field that is true."""
    return count(field, 1)


def count(field: int, value: int) -> Form:
    """A whole number, zero or more, or an enumeration's, as field."""
    return Form(_varint(field << 3 | _VARINT) + _varint(value))


def fixed(field: int, value: int) -> Form:
    """A whole number of 32 bits as field."""
    return Form(_varint(field << 3 | _FIXED) + value.to_bytes(4, "little"))


def number(field: int, value: float) -> Form:
    """A number as field."""
    return Form(_varint(field << 3 | _DOUBLE) + np.float64(value).tobytes())


def numbers(*values: float) -> Form:
    """Numbers as the fields 1, 2, ...: a vector, a quaternion, a colour."""
    return joined(*(number(field, value) for field, value in enumerate(values, 1)))


def column(field: int, place: int) -> Form:
    """A number as field that is filled in from a column."""
    return Form(_varint(field << 3 | _DOUBLE) + bytes(8), ((1, place),))


def columns(*places: int) -> Form:
    """Numbers as the fields 1, 2, ... that are filled in from columns."""
    return joined(*(column(field, place) for field, place in enumerate(places, 1)))


def stamp(field: int) -> Form:
    """A time, a message of seconds and nanoseconds, as field that is filled in."""
    head = _varint(field << 3 | _BYTES) + _varint(2 * (1 + _DIGITS))
    content = head + _varint(1 << 3 | _VARINT) + bytes(_DIGITS) + _varint(2 << 3 | _VARINT) + bytes(_DIGITS)
    return Form(content, (), (len(head),))


def filled(form: Form, values: Array, stamps: Stamps) -> Bytes:
    """(n, size) messages.

    Args:
        values: (n, m) numbers that are filled in.
        stamps: (n,) times, ns.
    """
    made = np.tile(np.frombuffer(form.content, np.uint8), (len(stamps), 1))
    for offset, place in form.places:
        made[:, offset : offset + 8] = np.ascontiguousarray(values[:, place], "<f8").view(np.uint8).reshape(-1, 8)
    whole, rest = _digits(stamps // _SECOND), _digits(stamps % _SECOND)
    for offset in form.stamps:
        made[:, offset + 1 : offset + 1 + _DIGITS] = whole
        made[:, offset + 2 + _DIGITS : offset + 2 + 2 * _DIGITS] = rest
    return made


def _digits(values: Stamps) -> Bytes:
    """(n, 5) numbers in groups of seven bits, the lowest first; all but the last say that more follow."""
    groups = values[:, None] >> np.uint64(7) * np.arange(_DIGITS, dtype=np.uint64) & np.uint64(0x7F)
    groups[:, :-1] |= np.uint64(0x80)
    return groups.astype(np.uint8)


def _varint(value: int) -> bytes:
    content = b""
    while value > 0x7F:
        content += bytes([value & 0x7F | 0x80])
        value >>= 7
    return content + bytes([value])
