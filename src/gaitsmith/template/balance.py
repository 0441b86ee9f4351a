"""Balance by the centre of pressure: the divergent component of the pendulum, its reference, and the weight shift."""

from __future__ import annotations

import math
from typing import NamedTuple

from gaitsmith.compiled import Vector, kernel
from gaitsmith.template.foothold import FootholdGains, pendulum_frequency
from gaitsmith.template.step import GaitInputs, StepState


class CopGains(NamedTuple):
    """:class:`CopParameters` as a kernel reads them."""

    gain_x: float
    gain_y: float
    margin: float


@kernel
def divergent_reference(
    step: StepState, gait: GaitInputs, gains: FootholdGains, com_height: float, side: float, time: float, out: Vector
) -> None:
    """Divergent component ξ = c + ċ/ω that a steady walk has, relative to the stance sole, heading frame.

    ``ξ_x = (vT/2)/sinh(ωT/2) e^{ω(t-T/2)}`` and laterally the same plus the sway ``±W/cosh(ωT/2) e^{ω(t-T/2)}``.

    Args:
        step: its ``speed`` is v.
        gait: latched.
        gains: of the preset.
        com_height: CoM above the stance sole, m.
        side: +1 if the swing leg is the left one.
        time: since the step began, s.
        out: (2,) m.
    """
    omega = pendulum_frequency(gains, com_height)
    duration = float(step.duration_ratio[0] * gait.period[0])
    half = 0.5 * omega * duration
    growth = math.exp(omega * min(time, duration) - half)
    for axis in range(2):
        out[axis] = 0.5 * step.speed[axis] * duration / math.sinh(half) * growth
    out[1] += side * gait.width[0] / math.cosh(half) * growth


@kernel
def stance_cop(gains: CopGains, omega: float, arm: Vector, velocity: Vector, wanted: Vector, out: Vector) -> None:
    """Centre of pressure that brings ξ back to its reference: k (ξ - ξ_ref) from the sole's origin, heading axes, m.

    Args:
        gains: k.
        omega: of the pendulum, 1/s.
        arm: (2,) CoM relative to the sole, m.
        velocity: (2,) of the CoM, m/s.
        wanted: (2,) reference of ξ, m.
        out: (2,).
    """
    out[0] = gains.gain_x * (arm[0] + velocity[0] / omega - wanted[0])
    out[1] = gains.gain_y * (arm[1] + velocity[1] / omega - wanted[1])


@kernel
def shift_acceleration(omega: float, arm: float, velocity: float, wanted: float, low: float, high: float) -> float:
    """CoM acceleration that drives ξ to a value on both feet: ``ω² (c - z)``, z = 2 ξ - ξ_ref clipped, m/s².

    Args:
        omega: of the pendulum, 1/s.
        arm: CoM relative to the sole along one axis, m.
        velocity: of the CoM, m/s.
        wanted: value of ξ to reach, m.
        low: least centre of pressure, relative to the sole, m.
        high: greatest.
    """
    xi = arm + velocity / omega
    return omega * omega * (arm - min(max(2.0 * xi - wanted, low), high))
