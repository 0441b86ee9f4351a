"""What a controller believes of its robot, for a backend that does not know the truth."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsmith.control.telemetry import Telemetry
from gaitsmith.simulation.truth import make_truth


class Belief:
    """Fills the columns of the truth from telemetry; positions are dead reckoning, ground contacts of bodies unknown.

    Args:
        dt: s from tick to tick.

    Attributes:
        truth, buffer, columns: as of :func:`gaitsmith.simulation.truth.make_truth`.
    """

    def __init__(self, telemetry: Telemetry, legs: Sequence[str], dt: float) -> None:
        self._telemetry, self._dt = telemetry, dt
        self.truth, self.buffer, self.columns = make_truth(legs)
        self.truth.least_separation[0] = np.inf
        self._start = np.zeros(2)

    def observe(self, tick: int) -> bool:
        """Follow one tick; never ends the run."""
        told, truth = self._telemetry, self.truth
        truth.com_velocity[:] = told.com_velocity
        truth.attitude[:] = *told.tilt[:2], told.yaw[0]
        cos, sin = math.cos(told.yaw[0]), math.sin(told.yaw[0])
        forward, left = told.com_velocity[:2]
        truth.torso[:2] += self._dt * (cos * forward - sin * left), self._dt * (sin * forward + cos * left)
        truth.hip_height[:] = told.hip_height[0]
        truth.force[:] = told.sole_force
        truth.foot_separation[0] = told.foot_actual[1] - told.foot_actual[4]
        truth.least_separation[0] = min(truth.least_separation[0], truth.foot_separation[0])
        truth.excursion[0] = max(truth.excursion[0], math.hypot(*(truth.torso[:2] - self._start)))
        truth.diverged[0] += not math.isfinite(float(truth.com_velocity.sum()))
        return False

    def hear(self, event: Mapping[str, Any]) -> None:
        """The excursion counts from the beginning of a walk."""
        if event.get("action") == "walk":
            self._start[:] = self.truth.torso[:2]
            self.truth.excursion[0] = 0.0
