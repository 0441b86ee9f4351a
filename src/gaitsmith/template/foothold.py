"""Foothold adjustment (Han 2023, eq. 15) with what removes its bias.

Eq. 15 alone misses the commanded speed, because the speed at the end of a step is not the step's mean. An integral
once a step removes the bias; at zero command a slow offset brings the robot back to its station.
"""

from __future__ import annotations

from typing import NamedTuple

from gaitsmith.compiled import Vector, kernel
from gaitsmith.robots.parameters import FootholdParameters
from gaitsmith.template.step import LEFT, Gait, StepState


class FootholdGains(NamedTuple):
    """:class:`FootholdParameters` as a kernel reads them."""

    velocity_gain_x: float
    velocity_gain_y: float
    acceleration_gain: float
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
def foothold_target(
    step: StepState,
    gait: Gait,
    gains: FootholdGains,
    velocity: Vector,
    acceleration: Vector,
    position: Vector,
    cos_yaw: float,
    sin_yaw: float,
    stance_y: float,
    out: Vector,
) -> None:
    """Where the swing sole should land, relative to the hip midpoint in the heading frame (eqs. 13 and 15).

    ``x = T v_d / 2 + k_v (v - v_d) - k_a a - I + station`` and the same laterally around ``±W``.

    Args:
        velocity: (2,) CoM velocity, heading frame, m/s.
        acceleration: (2,) CoM acceleration, heading frame, m/s².
        position: (2,) CoM position, world, m.
        cos_yaw: cosine of the heading.
        sin_yaw: sine of the heading.
        stance_y: lateral position of the stance sole, hip midpoint, heading frame, m.
        out: (2,) target, m.
    """
    side = -1.0 if step.stance[0] == LEFT else 1.0
    period = gait.period[0]
    error_x = velocity[0] - gait.speed[0]
    error_y = velocity[1] - gait.speed[1]
    x = 0.5 * period * gait.speed[0] + gains.velocity_gain_x * error_x - gains.acceleration_gain * acceleration[0]
    y = 0.5 * period * gait.speed[1] + gains.velocity_gain_y * error_y - gains.acceleration_gain * acceleration[1]
    x -= step.integral[0]
    y += side * gait.width[0] - step.integral[1]
    if step.station_kept[0] == 1:
        drift_x = position[0] - step.station[0]
        drift_y = position[1] - step.station[1]
        x += _clip(gains.station_gain_x * (cos_yaw * drift_x + sin_yaw * drift_y), gains.station_limit)
        y += _clip(gains.station_gain_y * (cos_yaw * drift_y - sin_yaw * drift_x), gains.station_limit)
    out[0] = _clip(x, gains.reach)
    apart = side * (y - stance_y)
    if apart < gains.separation:
        y = stance_y + side * gains.separation
    out[1] = _clip(y, gains.spread)


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
        if step.count[0] > 1:
            step.integral[axis] = _clip(
                step.integral[axis] + gain * (gait.speed[axis] - stride_mean), gains.integral_limit
            )
        step.last_mean_velocity[axis] = mean
        step.velocity_sum[axis] = 0.0
        step.position_sum[axis] = 0.0
        if step.station_kept[0] == 0:
            step.station[axis] = 0.5 * (place + step.last_position[axis])
        step.last_position[axis] = place
    step.velocity_ticks[0] = 0
