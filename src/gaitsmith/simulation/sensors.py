"""Sensor errors of the simulated robot: noise, bias, and quantisation, drawn from a seed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field

from gaitsmith.documents import Frozen

Deviation = Annotated[float, Field(ge=0.0, le=10.0)]
_BLOCK = 1024  # rows drawn at once: a draw per tick would cost more than the tick's physics


class SensorNoise(Frozen):
    """Standard deviations of white noise per sample, and constant errors.

    Attributes:
        gyro: rad/s per axis.
        accelerometer: m/s² per axis.
        accelerometer_bias: magnitude of a constant bias in a random direction, m/s².
        encoder: rad per joint.
        encoder_step: quantisation of the joint angles, rad; 0 for none.
        attitude: rad per axis of a rotation vector in body axes.
        sole_force: share of the robot's weight per sole.
    """

    gyro: Deviation = 0.02
    accelerometer: Deviation = 0.1
    accelerometer_bias: Deviation = 0.1
    encoder: Deviation = 3e-4
    encoder_step: Deviation = 1e-4
    attitude: Deviation = 0.005
    sole_force: Deviation = 0.01

    def bias(self, seed: int) -> npt.NDArray[np.float64]:
        """Constant accelerometer bias, body axes, (3,) in m/s², of magnitude ``accelerometer_bias``."""
        direction = np.random.default_rng([seed, 0xB1]).standard_normal(3)
        return self.accelerometer_bias * direction / np.linalg.norm(direction)

    def blocks(self, n_joints: int, n_soles: int, weight: float, seed: int) -> Iterator[npt.NDArray[np.float64]]:
        """Endless blocks of noise, one row a sample: gyro (3), accelerometer (3), attitude (3), encoders, soles.

        Args:
            weight: of the robot, N.
        """
        body, soles = np.random.default_rng([seed, 0xB2]), np.random.default_rng([seed, 0xB4])
        scale = np.repeat([self.gyro, self.accelerometer, self.attitude, self.encoder], [3, 3, 3, n_joints])
        block = np.empty((_BLOCK, 9 + n_joints + n_soles))
        while True:
            block[:, : len(scale)] = scale * body.standard_normal((_BLOCK, len(scale)))
            block[:, len(scale) :] = self.sole_force * weight * soles.standard_normal((_BLOCK, n_soles))
            yield block
