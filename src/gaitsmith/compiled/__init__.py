"""Compiled kernels: a disk cache that is the owner's alone, and arrays bound to a kernel once."""

from gaitsmith.compiled.binding import Arena as Arena
from gaitsmith.compiled.binding import Cube as Cube
from gaitsmith.compiled.binding import IntMatrix as IntMatrix
from gaitsmith.compiled.binding import IntVector as IntVector
from gaitsmith.compiled.binding import Matrix as Matrix
from gaitsmith.compiled.binding import Vector as Vector
from gaitsmith.compiled.binding import bind as bind
from gaitsmith.compiled.cache import kernel as kernel
