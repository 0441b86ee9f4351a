"""Foothold adjustment (Han 2023, eq. 15) with what removes its bias.

Eq. 15 alone misses the commanded speed, because the speed at the end of a step is not the step's mean. An integral
once a step removes the bias; at zero command a slow offset brings the robot back to its station.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from gaitsmith.compiled import Vector, kernel
from gaitsmith.template.step import LEFT, Gait, StepState

if TYPE_CHECKING:
    from gaitsmith.robots.parameters import FootholdParameters


_GRAVITY = 9.81
_LARGEST_ERROR = 0.1  # m/s, so that a push does not wind up the integral
_LOWEST_COM = 0.05  # m, keeps a fallen robot's pendulum finite


class FootholdGains(NamedTuple):
    """:class:`FootholdParameters` as a kernel reads them."""

    velocity_gain_x: float
    velocity_gain_y: float
    acceleration_gain: float
    deadbeat: float
    prediction: float
    mean_speed: float
    integral_gain_x: float
    integral_gain_y: float
    integral_limit: float
    station_gain_x: float
    station_gain_y: float
    station_limit: float
    reach: float
    spread: float
    separation: float


def make_foothold_gains(parameters: FootholdParameters) -> FootholdGains:
    """Kernel form of ``parameters``."""
    return FootholdGains(
        *parameters.velocity_gain,
        parameters.acceleration_gain,
        parameters.deadbeat,
        parameters.prediction,
        parameters.mean_speed,
        *parameters.integral_gain,
        parameters.integral_limit,
        *parameters.station_gain,
        parameters.station_limit,
        parameters.reach,
        parameters.spread,
        parameters.separation,
    )


@kernel
def _clip(value: float, bound: float) -> float:
    return min(max(value, -bound), bound)


@kernel
def pendulum_frequency(com_height: float) -> float:
    """ω of a linear pendulum with its mass ``com_height`` above the ground, 1/s."""
    return math.sqrt(_GRAVITY / max(com_height, _LOWEST_COM))


@kernel
def expected_duration(step: StepState, gait: Gait) -> float:
    """How long the present step will last, from how long steps have lasted, s."""
    return float(step.duration_ratio[0] * gait.period[0])


@kernel
def touchdown_velocity(
    step: StepState, gait: Gait, gains: FootholdGains, velocity: Vector, arm: Vector, out: Vector
) -> None:
    """CoM velocity that the foothold answers to, and the velocity to compare it with.

    A linear pendulum of the CoM's height above the stance sole, ``ω² = g / z``, forecasts the velocity at touchdown
    and tells how much faster than its mean it moves there: ``(ωT/2) coth(ωT/2)``.

    Args:
        step: the step being taken.
        gait: latched.
        gains: of the preset.
        velocity: (2,) CoM velocity, heading frame, m/s.
        arm: (3,) CoM relative to the stance sole, heading frame, m.
        out: (4,) velocity forward and lateral, reference forward and lateral, m/s.
    """
    omega = pendulum_frequency(arm[2])
    duration = expected_duration(step, gait)
    half = 0.5 * omega * duration
    ratio = 1.0 + gains.mean_speed * (half / math.tanh(half) - 1.0)
    remaining = omega * max(duration - step.time[0], 0.0)
    grow, carry = math.sinh(remaining), math.cosh(remaining)
    for axis in range(2):
        expected = carry * velocity[axis] + omega * grow * arm[axis]
        out[axis] = velocity[axis] + gains.prediction * (expected - velocity[axis])
        out[2 + axis] = ratio * gait.speed[axis]


@kernel
def foothold_target(
    step: StepState,
    gait: Gait,
    gains: FootholdGains,
    velocity: Vector,
    acceleration: Vector,
    drift: Vector,
    com_height: float,
    com_offset: Vector,
    stance_y: float,
    out: Vector,
) -> None:
    """Where the swing sole should land, relative to the hip midpoint in the heading frame (eqs. 13 and 15).

    ``x = T v_d / 2 + k_v (v - v_d) - k_a a - I + station`` and the same laterally around ``±W``, where the preset's
    shares blend the paper's terms with a linear pendulum's: k_v with ``coth(ωT) / ω``, T with how long steps really
    last, the hip midpoint with the CoM. The separation from the stance sole comes last and is never undone.

    Args:
        step: the step being taken.
        gait: latched.
        gains: of the preset.
        velocity: (4,) from :func:`touchdown_velocity`.
        acceleration: (2,) CoM acceleration, heading frame, m/s².
        drift: (2,) CoM position relative to the station, heading frame, m.
        com_height: CoM above the stance sole, m.
        com_offset: (2,) CoM relative to the hip midpoint, heading frame, m.
        stance_y: lateral position of the stance sole, hip midpoint, heading frame, m.
        out: (2,) target, m.
    """
    side = -1.0 if step.stance[0] == LEFT else 1.0
    omega = pendulum_frequency(com_height)
    expected = expected_duration(step, gait)
    deadbeat = 1.0 / (omega * math.tanh(omega * expected))
    duration = gait.period[0] + gains.mean_speed * (expected - gait.period[0])
    for axis in range(2):
        gain = gains.velocity_gain_x if axis == 0 else gains.velocity_gain_y
        gain += gains.deadbeat * (deadbeat - gain)
        out[axis] = (
            0.5 * duration * gait.speed[axis]
            + gain * (velocity[axis] - velocity[2 + axis])
            - gains.acceleration_gain * acceleration[axis]
            - step.integral[axis]
            + gains.mean_speed * com_offset[axis]
        )
        if step.station_kept[0] == 1:
            station = gains.station_gain_x if axis == 0 else gains.station_gain_y
            out[axis] += _clip(station * drift[axis], gains.station_limit)
    out[0] = _clip(out[0], gains.reach)
    y = _clip(out[1] + side * gait.width[0], gains.spread)
    if side * (y - stance_y) < gains.separation:
        y = stance_y + side * gains.separation
    out[1] = y


@kernel
def observe_motion(step: StepState, velocity: Vector, position: Vector) -> None:
    """Add one tick's CoM velocity (heading frame) and position (world) to the step's means."""
    for axis in range(2):
        step.velocity_sum[axis] += velocity[axis]
        step.position_sum[axis] += position[axis]
    step.velocity_ticks[0] += 1


@kernel
def finish_step(step: StepState, gait: Gait, gains: FootholdGains) -> None:
    """Update integral and station from the step that just ended (once a step, before the new gait is latched)."""
    ticks = step.velocity_ticks[0]
    if ticks == 0:
        return
    for axis in range(2):
        mean = step.velocity_sum[axis] / ticks
        place = step.position_sum[axis] / ticks
        # Lateral sway has opposite signs on the two legs: only the mean over a stride says anything.
        stride_mean = 0.5 * (mean + step.last_mean_velocity[axis])
        gain = gains.integral_gain_x if axis == 0 else gains.integral_gain_y
        if step.settling[0] == 0:
            error = _clip(gait.speed[axis] - stride_mean, _LARGEST_ERROR)
            step.integral[axis] = _clip(step.integral[axis] + gain * error, gains.integral_limit)
        step.last_mean_velocity[axis] = mean
        step.velocity_sum[axis] = 0.0
        step.position_sum[axis] = 0.0
        if step.station_kept[0] == 0:
            step.station[axis] = 0.5 * (place + step.last_position[axis])
        step.last_position[axis] = place
    step.velocity_ticks[0] = 0
    step.settling[0] = max(step.settling[0] - 1, 0)
