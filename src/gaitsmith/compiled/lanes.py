"""Eight neighbours of a matrix row at once, in registers: what the compiler does not find by itself.

``take`` and ``put`` may reach beyond the last column: storage whose rows they read has :func:`padded` columns, and
comes from :func:`storage`. Sums are not contracted, so that every machine finds the same ones.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic, models, register_model

LANES = 8
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)


def padded(n: int) -> int:
    """Columns of storage whose rows are read eight at a time: n, rounded up."""
    return -(-n // LANES) * LANES


def storage(*shape: int) -> npt.NDArray[np.float64]:
    """Zeros with padded columns, where eight neighbours never lie in two lines of the processor's cache."""
    extents = (*shape[:-1], padded(shape[-1]))
    line = 8 * LANES  # bytes
    memory = np.zeros(8 * math.prod(extents) + line, dtype=np.uint8)
    first = -memory.ctypes.data % line
    return memory[first : first + memory.size - line].view(np.float64).reshape(extents)


class Lanes(types.Type):
    """Eight floats in a register."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


_lanes = Lanes()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    """One vector."""

    def __init__(self, manager: Any, lanes: Lanes) -> None:
        super().__init__(manager, lanes, _VECTOR)


def _place(context: Any, builder: Any, kind: Any, matrix: Any, row: Any, column: Any) -> Any:
    """Pointer to eight entries of a C-contiguous matrix."""
    array = context.make_array(kind)(context, builder, matrix)
    width = builder.extract_value(array.shape, 1)
    at = builder.gep(array.data, [builder.add(builder.mul(row, width), column)])
    return builder.bitcast(at, _VECTOR.as_pointer())


def _spread(builder: Any, share: Any) -> Any:
    """A number in all lanes."""
    first = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), share, ir.Constant(ir.IntType(32), 0))
    mask = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(first, ir.Constant(_VECTOR, ir.Undefined), mask)


@intrinsic
def entry(typingctx: Any, matrix: Any, row: Any, column: Any) -> Any:
    """One entry; unlike ``matrix[row, column]`` it is not asked whether its place is counted from the end."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, args[0])
        width = builder.extract_value(array.shape, 1)
        return builder.load(builder.gep(array.data, [builder.add(builder.mul(args[1], width), args[2])]))

    return types.float64(matrix, types.int64, types.int64), codegen


@intrinsic
def none(typingctx: Any) -> Any:
    """Zeros."""
    return _lanes(), lambda context, builder, signature, args: ir.Constant(_VECTOR, [0.0] * LANES)


@intrinsic
def take(typingctx: Any, matrix: Any, row: Any, column: Any) -> Any:
    """Eight entries of a row, from a column on."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load(_place(context, builder, signature.args[0], *args), align=8)

    return _lanes(matrix, types.int64, types.int64), codegen


@intrinsic
def put(typingctx: Any, matrix: Any, row: Any, column: Any, values: Any) -> Any:
    """Write eight entries of a row, from a column on."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        builder.store(args[3], _place(context, builder, signature.args[0], *args[:3]), align=8)
        return context.get_dummy_value()

    return types.void(matrix, types.int64, types.int64, values), codegen


@intrinsic
def times(typingctx: Any, values: Any, share: Any) -> Any:
    """``share * values``."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fmul(args[0], _spread(builder, args[1]))

    return values(values, types.float64), codegen


@intrinsic
def plus(typingctx: Any, values: Any, share: Any, others: Any) -> Any:
    """``values + share * others``."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fadd(args[0], builder.fmul(_spread(builder, args[1]), args[2]))

    return values(values, types.float64, others), codegen
