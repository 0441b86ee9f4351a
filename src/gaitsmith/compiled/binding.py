"""Arrays bound to a kernel once, so that a call passes one integer and allocates nothing.

Unboxing an array argument costs a heap allocation in numba's runtime, and a controller has a hundred of them.
An :class:`Arena` keeps named tuples of arrays alive and writes their addresses and shapes into a table; inside a
kernel :func:`bind` is such a tuple as an address into that table: a field is loaded where it is named.
"""

from __future__ import annotations

from typing import Annotated, Any, Generic, NamedTuple, TypeVar, get_type_hints

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, intrinsic, models, register_model, typeof_impl, unbox
from numba.np import arrayobj

Vector = Annotated[npt.NDArray[np.float64], 1]
Matrix = Annotated[npt.NDArray[np.float64], 2]
Cube = Annotated[npt.NDArray[np.float64], 3]
IntVector = Annotated[npt.NDArray[np.int64], 1]
IntMatrix = Annotated[npt.NDArray[np.int64], 2]

_WORDS = 4  # table words per field: address, of a group that of its own table, and up to three extents
_Bound = TypeVar("_Bound", bound=tuple[Any, ...])


class _Field(NamedTuple):
    """How an array or scalar lies in memory: its type and number of axes (0 for a value read at binding)."""

    dtype: np.dtype[Any]
    axes: int


def _is_group(hint: Any) -> bool:
    """Whether an annotation is a named tuple of its own."""
    return isinstance(hint, type) and issubclass(hint, tuple) and hasattr(hint, "_fields")


def _layout(cls: type) -> dict[str, Any]:
    """Memory layout of a named tuple's fields, from its annotations: a :class:`_Field`, or the class of a group."""
    found: dict[str, Any] = {}
    for name, hint in get_type_hints(cls, include_extras=True).items():
        if hint is float:
            found[name] = _Field(np.dtype(np.float64), 0)
        elif hint is int:
            found[name] = _Field(np.dtype(np.int64), 0)
        elif _is_group(hint):
            found[name] = hint
        elif hasattr(hint, "__metadata__"):
            is_int = hint in (IntVector, IntMatrix)
            found[name] = _Field(np.dtype(np.int64 if is_int else np.float64), hint.__metadata__[0])
        else:
            raise TypeError(f"{cls.__name__}.{name}: {hint!r} cannot be bound; use float, int, an array, a named tuple")
    return found


class View(types.Type):
    """Inside a kernel: a bound named tuple, as the address of its first row."""

    def __init__(self, cls: type) -> None:
        self.cls = cls
        super().__init__(name=f"View({cls.__module__}.{cls.__qualname__})")


@register_model(View)
class _ViewModel(models.PrimitiveModel):
    """One 64-bit integer."""

    def __init__(self, manager: Any, view: View) -> None:
        super().__init__(manager, view, ir.IntType(64))


def _field_type(field: _Field) -> Any:
    """Type of an array or scalar inside a kernel."""
    scalar = types.float64 if field.dtype == np.float64 else types.int64
    return scalar if field.axes == 0 else types.Array(scalar, field.axes, "C")


@infer_getattr
class _ViewAttribute(AttributeTemplate):
    """Types of the fields of a view."""

    key = View

    def generic_resolve(self, view: View, name: str) -> Any:
        """Type of one field, None if there is no such field."""
        field = _layout(view.cls).get(name)
        if field is None:
            return None
        return _field_type(field) if isinstance(field, _Field) else View(field)


@lower_getattr_generic(View)
def _lower_field(context: Any, builder: Any, view: View, address: Any, name: str) -> Any:
    """Load one field of a view, and nothing else of it; nothing writes to the table while a kernel runs."""
    layout = _layout(view.cls)
    row = builder.add(address, ir.IntType(64)(8 * _WORDS * [*layout].index(name)))
    return _loaded(context, builder, layout[name], builder.inttoptr(row, ir.IntType(64).as_pointer()))


def _constant(builder: Any, pointer: Any) -> Any:
    """Load what does not change while a kernel runs, so that loops need not load it again."""
    loaded = builder.load(pointer)
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


def _loaded(context: Any, builder: Any, field: Any, row: Any) -> Any:
    """The array, scalar or group of one row."""
    word = ir.IntType(64)
    if not isinstance(field, _Field):
        return _constant(builder, row)
    member = _field_type(field)
    words = [_constant(builder, builder.gep(row, [word(k)])) for k in range(1 + field.axes)]
    scalar = member if field.axes == 0 else member.dtype
    data = builder.inttoptr(words[0], context.get_data_type(scalar).as_pointer())
    if field.axes == 0:
        return _constant(builder, data)
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
    return array._getvalue()


@intrinsic
def bind(typingctx: Any, cls: Any, table: Any) -> Any:
    """``bind(Class, table_address)`` inside a kernel: the named tuple that an :class:`Arena` keeps there.

    Array fields are views of the arena's memory; ``float`` and ``int`` fields are copies of its present value; a
    field that is a named tuple is bound the same way, when it is first named.
    """
    python_class = cls.instance_class

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return args[1]

    return View(python_class)(cls, types.int64), codegen


class Arena(Generic[_Bound]):
    """Owns the arrays of one kernel and the tables that tell the kernel where they lie.

    From Python a kernel takes an arena where another kernel passes a view.

    Args:
        view: a named tuple whose annotations are ``float``, ``int``, the array kinds of this module, or named tuples
            of these. Arrays that are already C-contiguous with the right dtype are shared, not copied; so is a group
            that is part of several groups.

    Attributes:
        view: the same tuple over the arena's own memory; a scalar field is a one-element array there, so that
            ``arena.view.gains.gain[0] = 2.0`` reaches the kernel at its next call.
        address: address of the table, the second argument of :func:`bind`.
    """

    def __init__(self, view: _Bound) -> None:
        self._kept: dict[int, tuple[Any, Any, npt.NDArray[np.int64]]] = {}  # by group: itself, its copy, its table
        self.view: _Bound = self._keep(view)
        self.address: int = self._kept[id(view)][2].ctypes.data

    def _keep(self, group: Any) -> Any:
        """The group over memory that the arena owns, and its table."""
        if id(group) in self._kept:
            return self._kept[id(group)][1]
        kept: list[Any] = []
        rows: list[list[int]] = []
        for (name, field), value in zip(_layout(type(group)).items(), group, strict=True):
            if not isinstance(field, _Field):
                kept.append(self._keep(value))
                rows.append([self._kept[id(value)][2].ctypes.data, 0, 0, 0])
                continue
            array = np.ascontiguousarray(value, dtype=field.dtype)
            if array.ndim != max(field.axes, 1) or (field.axes == 0 and array.size != 1):
                raise TypeError(f"{type(group).__name__}.{name}: shape {np.shape(value)}, expected {field.axes} axes")
            kept.append(array)
            extents = list(array.shape) if field.axes else []
            rows.append([array.ctypes.data, *extents] + [0] * (_WORDS - 1 - len(extents)))
        self._kept[id(group)] = (group, type(group)(*kept), np.array(rows, dtype=np.int64))
        return self._kept[id(group)][1]


@typeof_impl.register(Arena)
def _typeof_arena(arena: Arena[Any], context: object) -> View:
    """From Python a kernel sees an arena as its view."""
    return View(type(arena.view))


@unbox(View)
def _unbox_arena(view: View, arena: Any, c: Any) -> NativeValue:
    """The address of an arena's table."""
    number = c.pyapi.object_getattr_string(arena, "address")
    address = c.pyapi.long_as_longlong(number)
    c.pyapi.decref(number)
    return NativeValue(address)
