"""Rotations: matrices as nine entries row by row, quaternions w x y z, and the turn about the vertical.

Kernels take and return tuples of numbers, so that no array is made; :func:`rotation_matrix` is for code that reads a
model once.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gaitsmith.compiled import Matrix, Vector, kernel


def scaled_rotation_entries(s: Any, w: Any, x: Any, y: Any, z: Any) -> tuple[Any, ...]:
    """Entries of a quaternion's rotation matrix, row by row; ``s`` is 2 over its squared length. Symbols will do."""
    return (
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
    )


_scaled = kernel(scaled_rotation_entries)


@kernel
def rotation_entries(w: float, x: float, y: float, z: float) -> tuple[float, ...]:
    """The nine entries, row by row, of a quaternion's rotation matrix; any length, zero counts as no rotation."""
    norm = w * w + x * x + y * y + z * z
    return _scaled(2.0 / norm if norm > 1e-300 else 0.0, w, x, y, z)


@kernel
def entries(m: Matrix) -> tuple[float, ...]:
    """The nine entries of a 3 x 3 matrix, row by row."""
    return (m[0, 0], m[0, 1], m[0, 2], m[1, 0], m[1, 1], m[1, 2], m[2, 0], m[2, 1], m[2, 2])


@kernel
def product_entries(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    """Entries, row by row, of the product of two 3 x 3 matrices given in the same way."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@kernel
def turned(r: tuple[float, ...], x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector turned by a rotation given as nine entries row by row."""
    return r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z, r[6] * x + r[7] * y + r[8] * z


@kernel
def axis_angle_entries(x: float, y: float, z: float, angle: float) -> tuple[float, ...]:
    """Entries, row by row, of the rotation by ``angle`` (rad) about a unit axis (Rodrigues' formula)."""
    s, c = math.sin(angle), math.cos(angle)
    k = 1.0 - c
    return (
        c + k * x * x,
        k * x * y - s * z,
        k * x * z + s * y,
        k * x * y + s * z,
        c + k * y * y,
        k * y * z - s * x,
        k * x * z - s * y,
        k * y * z + s * x,
        c + k * z * z,
    )


@kernel
def turn_quaternion(quaternion: Vector, x: float, y: float, z: float) -> None:
    """Multiply a quaternion from the right by the rotation vector (x, y, z), rad, body axes, and normalise it."""
    angle = math.sqrt(x * x + y * y + z * z)
    half = 0.5 * math.sin(0.5 * angle) / (0.5 * angle) if angle > 1e-8 else 0.5
    c, x, y, z = math.cos(0.5 * angle), half * x, half * y, half * z
    q0, q1, q2, q3 = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    w = q0 * c - q1 * x - q2 * y - q3 * z
    a = q0 * x + q1 * c + q2 * z - q3 * y
    b = q0 * y - q1 * z + q2 * c + q3 * x
    d = q0 * z + q1 * y - q2 * x + q3 * c
    over = 1.0 / math.sqrt(w * w + a * a + b * b + d * d)
    quaternion[0], quaternion[1], quaternion[2], quaternion[3] = w * over, a * over, b * over, d * over


@kernel
def heading_to_world(cos_yaw: float, sin_yaw: float, x: float, y: float) -> tuple[float, float]:
    """A horizontal vector from axes turned by the yaw angle to the world's."""
    return cos_yaw * x - sin_yaw * y, sin_yaw * x + cos_yaw * y


@kernel
def world_to_heading(cos_yaw: float, sin_yaw: float, x: float, y: float) -> tuple[float, float]:
    """A horizontal vector from the world's axes to those turned by the yaw angle."""
    return cos_yaw * x + sin_yaw * y, cos_yaw * y - sin_yaw * x


def rotation_matrix(quaternion: Vector) -> Matrix:
    """(3, 3) rotation matrix of a quaternion w x y z, for code outside kernels."""
    scale = 2.0 / float(np.dot(quaternion, quaternion))
    return np.array(scaled_rotation_entries(scale, *quaternion)).reshape(3, 3)
