"""Arrays bound to a kernel once, so that a call passes one integer and allocates nothing.

Unboxing an array argument costs a heap allocation in numba's runtime, and a controller has a hundred of them.
An :class:`Arena` keeps named tuples of arrays alive and writes their addresses and shapes into a table; inside a
kernel :func:`bind` rebuilds a named tuple from that table as plain structs without reference counts.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple, TypeVar, get_type_hints

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np import arrayobj

Vector = Annotated[npt.NDArray[np.float64], 1]
Matrix = Annotated[npt.NDArray[np.float64], 2]
Cube = Annotated[npt.NDArray[np.float64], 3]
IntVector = Annotated[npt.NDArray[np.int64], 1]
IntMatrix = Annotated[npt.NDArray[np.int64], 2]

_WORDS = 4  # table words per field: address and up to three extents
_Bound = TypeVar("_Bound", bound=tuple[Any, ...])


class _Field(NamedTuple):
    """How a named tuple's field lies in memory: scalar type and number of axes (0 for a value read at binding)."""

    dtype: np.dtype[Any]
    axes: int


def _fields(cls: type) -> list[_Field]:
    """Memory layout of a named tuple's fields, from its annotations."""
    found = []
    for name, hint in get_type_hints(cls, include_extras=True).items():
        if hint is float:
            found.append(_Field(np.dtype(np.float64), 0))
        elif hint is int:
            found.append(_Field(np.dtype(np.int64), 0))
        elif hasattr(hint, "__metadata__"):
            is_int = hint in (IntVector, IntMatrix)
            found.append(_Field(np.dtype(np.int64 if is_int else np.float64), hint.__metadata__[0]))
        else:
            raise TypeError(f"{cls.__name__}.{name}: {hint!r} cannot be bound; use float, int, Vector, Matrix, Cube")
    return found


@intrinsic
def bind(typingctx: Any, cls: Any, table: Any, first: Any) -> Any:
    """``bind(Class, table_address, first_index)`` inside a kernel: the named tuple stored there by an Arena.

    Array fields are views of the arena's memory; ``float`` and ``int`` fields are copies of its present value.
    """
    python_class = cls.instance_class
    fields = _fields(python_class)
    scalars = [types.float64 if f.dtype == np.float64 else types.int64 for f in fields]
    members = [s if f.axes == 0 else types.Array(s, f.axes, "C") for f, s in zip(fields, scalars, strict=True)]
    result = types.NamedTuple(members, python_class)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        word = ir.IntType(64)
        rows = builder.inttoptr(args[1], word.as_pointer())
        values = []
        for index, (field, scalar, member) in enumerate(zip(fields, scalars, members, strict=True)):
            row = builder.mul(builder.add(args[2], word(index)), word(_WORDS))
            words = [builder.load(builder.gep(rows, [builder.add(row, word(k))])) for k in range(1 + field.axes)]
            data_type = context.get_data_type(scalar).as_pointer()
            data = builder.inttoptr(words[0], data_type)
            if field.axes == 0:
                values.append(builder.load(data))
                continue
            array = arrayobj.make_array(member)(context, builder)
            strides = [word(8)]
            for extent in reversed(words[2:]):
                strides.insert(0, builder.mul(strides[0], extent))
            arrayobj.populate_array(
                array,
                data=data,
                shape=cgutils.pack_array(builder, words[1:]),
                strides=cgutils.pack_array(builder, strides),
                itemsize=word(8),
                meminfo=None,
            )
            values.append(array._getvalue())
        return context.make_tuple(builder, signature.return_type, values)

    return result(cls, types.int64, types.int64), codegen


class Arena:
    """Owns the arrays of one kernel and the table that tells the kernel where they lie.

    Args:
        groups: instances of named tuples whose annotations are ``float``, ``int``, or the array kinds of this
            module. Arrays that are already C-contiguous with the right dtype are shared, not copied.

    Attributes:
        groups: the same tuples over the arena's own memory; a scalar field is a one-element array there, so that
            ``arena.groups[k].gain[0] = 2.0`` reaches the kernel at its next call.
        first: table index of every group, the third argument of :func:`bind`.
        address: address of the table, the second argument of :func:`bind`.
    """

    def __init__(self, *groups: tuple[Any, ...]) -> None:
        self.groups: list[Any] = []
        self.first: list[int] = []
        rows: list[list[int]] = []
        for group in groups:
            self.first.append(len(rows))
            kept = []
            for name, field, value in zip(group._fields, _fields(type(group)), group, strict=True):  # type: ignore[attr-defined]
                array = np.ascontiguousarray(value, dtype=field.dtype)
                if array.ndim != max(field.axes, 1) or (field.axes == 0 and array.size != 1):
                    raise TypeError(
                        f"{type(group).__name__}.{name}: shape {np.shape(value)}, expected {field.axes} axes"
                    )
                kept.append(array)
                extents = list(array.shape) if field.axes else []
                rows.append([array.ctypes.data, *extents] + [0] * (_WORDS - 1 - len(extents)))
            self.groups.append(type(group)(*kept))
        self._table = np.array(rows, dtype=np.int64)
        self.address: int = self._table.ctypes.data
