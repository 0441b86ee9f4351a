"""Where commands lead: the ground around the path that speeds and turns describe."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from gaitsmith.simulation.terrain import Region

_MARGIN = 3.0  # m of prepared ground around the commanded path; a tour stays within
_SAMPLES = 17  # of a turn
Part = tuple[float, tuple[float, float], float]
"""How long, s, at which speed forward and to the left, m/s, and how fast it turns, rad/s."""


def region_around(parts: Iterable[Part]) -> Region:
    """Ground around a path that begins at the origin, forward."""
    place, heading = np.zeros(2), 0.0
    lowest, highest = np.zeros(2), np.zeros(2)
    for lasts, speed, yaw_rate in parts:
        turned = yaw_rate * lasts
        for angle in np.linspace(0.0, math.copysign(min(abs(turned), 2.0 * math.pi), turned), _SAMPLES)[1:]:
            length = lasts if yaw_rate == 0.0 else angle / yaw_rate
            seen = place + length * _turned(speed, heading, angle)
            lowest, highest = np.minimum(lowest, seen), np.maximum(highest, seen)
        place = place + lasts * _turned(speed, heading, turned)
        heading += turned
    (x, y), (far_x, far_y) = lowest.tolist(), highest.tolist()
    return Region((x - _MARGIN, far_x + _MARGIN), (y - _MARGIN / 2, far_y + _MARGIN / 2))


def _turned(speed: tuple[float, float], heading: float, angle: float) -> NDArray[np.float64]:
    """(2,) mean velocity in the world while the heading turns evenly by an angle, rad, and the speed stays, m/s."""
    chord = float(np.sinc(angle / (2.0 * math.pi)))
    c, s = math.cos(heading + angle / 2.0), math.sin(heading + angle / 2.0)
    return chord * np.array([c * speed[0] - s * speed[1], s * speed[0] + c * speed[1]])
