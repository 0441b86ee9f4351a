"""Foothold adjustment (Han 2023, eq. 15) with what removes its bias.

Eq. 15 alone misses the commanded speed, because the speed at the end of a step is not the step's mean. An integral
once a step, and station keeping at zero command, change the speed that a step is taken for; foothold and balance read
that speed alike.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from gaitsmith.compiled import Vector, kernel
from gaitsmith.template.step import GaitInputs, StepState

if TYPE_CHECKING:
    from gaitsmith.robots.presets import FootholdParameters, SpeedParameters

SETTLING_STEPS = 3  # a new speed is reached within two steps and averaged over two


class FootholdGains(NamedTuple):
    """:class:`FootholdParameters` as a kernel reads them, with the gravity (m/s²) and what bounds heights (m).

    Attributes:
        lowest_com: least height of a CoM.
        lowest_hips: least height of the hips.
        leg: greatest height of the hips: how far a leg reaches.
    """

    velocity_gain_x: float
    velocity_gain_y: float
    acceleration_gain: float
    deadbeat: float
    prediction: float
    mean_speed: float
    sway: float
    reach: float
    spread: float
    separation: float
    gravity: float
    lowest_com: float
    lowest_hips: float
    leg: float


class SpeedGains(NamedTuple):
    """:class:`SpeedParameters` as a kernel reads them."""

    integral_gain_x: float
    integral_gain_y: float
    integral_limit: float
    largest_error: float
    station_gain_x: float
    station_gain_y: float
    station_limit: float
    settled_speed: float


class Forecast(NamedTuple):
    """The pendulum over the stance sole; heading frame.

    Attributes:
        arm: (3,) CoM relative to the stance sole, m.
        velocity: (2,) CoM velocity that the foothold answers to, m/s.
        wanted: (2,) what it is compared with, m/s.
        acceleration: (2,) of the CoM, as the last whole-body solution predicted it, m/s².
        drift: (2,) CoM relative to the station, m.
    """

    arm: Vector
    velocity: Vector
    wanted: Vector
    acceleration: Vector
    drift: Vector


def make_foothold_gains(
    parameters: FootholdParameters, gravity: float, com_height: float, heights: tuple[float, float]
) -> FootholdGains:
    """Kernel form of ``parameters``; ``com_height`` is that of the standing robot, ``heights`` bound its hips', m."""
    values = parameters.model_dump()
    gain_x, gain_y = values.pop("velocity_gain")
    return FootholdGains(
        velocity_gain_x=gain_x,
        velocity_gain_y=gain_y,
        gravity=gravity,
        lowest_com=0.07 * com_height,
        lowest_hips=heights[0],
        leg=heights[1],
        **values,
    )


def make_speed_gains(parameters: SpeedParameters) -> SpeedGains:
    """Kernel form of ``parameters``."""
    values = parameters.model_dump()
    pairs = {name: values.pop(name) for name in ("integral_gain", "station_gain")}
    split = {f"{name}_{axis}": pair[k] for name, pair in pairs.items() for k, axis in enumerate("xy")}
    return SpeedGains(**split, **values)


@kernel
def clip(value: float, bound: float) -> float:
    """``value`` within ``±bound``."""
    return min(max(value, -bound), bound)


@kernel
def pendulum_frequency(gains: FootholdGains, com_height: float) -> float:
    """ω of a linear pendulum with its mass ``com_height`` above the ground, 1/s."""
    return math.sqrt(gains.gravity / max(com_height, gains.lowest_com))


@kernel
def expected_duration(step: StepState) -> float:
    """How long the present step will last, from how long steps have lasted, s."""
    return float(step.duration_ratio[0] * step.period[0])


@kernel
def choose_speed(step: StepState, gait: GaitInputs, gains: SpeedGains, forecast: Forecast) -> None:
    """The speed that this step is taken for: the command, what removes its bias, and at zero command the way home."""
    home_x, home_y = gains.station_gain_x * forecast.drift[0], gains.station_gain_y * forecast.drift[1]
    share = step.station_kept[0] * min(1.0, gains.station_limit / max(math.hypot(home_x, home_y), 1e-12))
    step.speed[0] = gait.speed[0] + step.integral[0] - share * home_x
    step.speed[1] = gait.speed[1] + step.integral[1] - share * home_y


@kernel
def forecast_touchdown(
    step: StepState, gait: GaitInputs, gains: FootholdGains, velocity: Vector, side: float, forecast: Forecast
) -> None:
    """CoM velocity that the foothold answers to, and the velocity to compare it with.

    A linear pendulum of the CoM's height above the stance sole, ``ω² = g / z``, forecasts the velocity at touchdown
    and tells how much faster than its mean it moves there, ``(ωT/2) coth(ωT/2)``, and how fast it sways between soles
    ``2 W`` apart, ``ωW tanh(ωT/2)`` towards the swing side.

    Args:
        step: the step being taken.
        gait: latched.
        gains: of the preset.
        velocity: (2,) CoM velocity, heading frame, m/s.
        side: +1 if the swing leg is the left one.
        forecast: its ``arm`` is read; velocity and wanted are filled.
    """
    omega = pendulum_frequency(gains, forecast.arm[2])
    half = 0.5 * omega * step.duration_ratio[0] * gait.period[0]
    ratio = 1.0 + gains.mean_speed * (half / math.tanh(half) - 1.0)
    remaining = omega * max(expected_duration(step) - step.time[0], 0.0)
    grow, carry = math.sinh(remaining), math.cosh(remaining)
    for axis in range(2):
        expected = carry * velocity[axis] + omega * grow * forecast.arm[axis]
        forecast.velocity[axis] = velocity[axis] + gains.prediction * (expected - velocity[axis])
        forecast.wanted[axis] = ratio * step.speed[axis]
    forecast.wanted[1] += gains.sway * side * omega * gait.width[0] * math.tanh(half)


@kernel
def foothold_target(
    step: StepState,
    gait: GaitInputs,
    gains: FootholdGains,
    forecast: Forecast,
    com_offset: Vector,
    stance_y: float,
    side: float,
    out: Vector,
) -> bool:
    """Where the swing sole should land, relative to the hip midpoint in the heading frame (eqs. 13 and 15).

    ``x = T v / 2 + k_v (v̂ - v*) - k_a a`` and the same laterally around ``±W``, where the preset's shares blend the
    paper's terms with a linear pendulum's: k_v with ``coth(ωT) / ω``, T with how long steps really last, the hip
    midpoint with the CoM. The separation from the stance sole comes last and is never undone.

    Args:
        step: the step being taken; its ``speed`` is v.
        gait: latched.
        gains: of the preset.
        forecast: from :func:`forecast_touchdown`.
        com_offset: (2,) CoM relative to the hip midpoint, heading frame, m.
        stance_y: lateral position of the stance sole, hip midpoint, heading frame, m.
        side: +1 if the swing leg is the left one.
        out: (2,) target, m.

    Returns:
        True if the target is beside the stance sole and moves with it.
    """
    omega = pendulum_frequency(gains, forecast.arm[2])
    expected = float(step.duration_ratio[0] * gait.period[0])  # the next step takes the commanded period
    deadbeat = 1.0 / (omega * math.tanh(omega * expected))
    duration = gait.period[0] + gains.mean_speed * (expected - gait.period[0])
    for axis in range(2):
        gain = gains.velocity_gain_x if axis == 0 else gains.velocity_gain_y
        gain += gains.deadbeat * (deadbeat - gain)
        out[axis] = (
            0.5 * duration * step.speed[axis]
            + gain * (forecast.velocity[axis] - forecast.wanted[axis])
            - gains.acceleration_gain * forecast.acceleration[axis]
            + gains.mean_speed * com_offset[axis]
        )
    out[0] = clip(out[0], gains.reach)
    y = clip(out[1] + side * gait.width[0], gains.spread)
    beside = side * (y - stance_y) < gains.separation
    out[1] = stance_y + side * gains.separation if beside else y
    return bool(beside)


@kernel
def landing_height(gait: GaitInputs, gains: FootholdGains, foothold: Vector, side: float, drop: float) -> float:
    """Height of the hips at touchdown, m: lower than H where the leg is too short for so far a foothold.

    Only what goes beyond the foothold of the commanded walk counts, so that undisturbed walking keeps its height, and
    how far the ground there is below the stance sole: ``drop``, m. Before a drop as deep as the lift all of it counts.
    """
    room = gains.leg * gains.leg
    level = 1.0 - min(drop / max(gait.lift[0], 1e-6), 1.0)
    for axis in range(2):
        usual = side * gait.width[0] if axis == 1 else 0.0
        beyond = abs(foothold[axis] - usual) - level * 0.5 * gait.period[0] * abs(gait.speed[axis])
        room -= max(beyond, 0.0) ** 2
    return min(float(gait.height[0]), max(math.sqrt(max(room, 0.0)) - drop, gains.lowest_hips))


@kernel
def observe_motion(step: StepState, velocity: Vector, position: Vector) -> None:
    """Add one tick's CoM velocity (heading frame) and position (world) to the step's means."""
    for axis in range(2):
        step.velocity_sum[axis] += velocity[axis]
        step.position_sum[axis] += position[axis]
    step.velocity_ticks[0] += 1


@kernel
def finish_step(step: StepState, gait: GaitInputs, gains: SpeedGains) -> None:
    """Update integral and station from the step that just ended (once a step, before the new gait is latched).

    A bias is what stays: after a stride that is much faster or slower than the one before, as after a push, nothing is
    learnt for a while, and what the step before taught is undone: the push may have begun in it. What was aimed for is
    the command and the way home, so that going home is no error.
    """
    ticks = step.velocity_ticks[0]
    if ticks == 0:
        return
    settled = step.settling[0] == 0
    for axis in range(2):
        # Lateral sway has opposite signs on the two legs: only the mean over a stride says anything.
        stride_mean = 0.5 * (step.velocity_sum[axis] / ticks + step.last_mean_velocity[axis])
        if abs(stride_mean - step.stride_mean[axis]) > gains.largest_error:
            step.settling[0] = SETTLING_STEPS
    for axis in range(2):
        mean = step.velocity_sum[axis] / ticks
        place = step.position_sum[axis] / ticks
        stride_mean = 0.5 * (mean + step.last_mean_velocity[axis])
        gain = gains.integral_gain_x if axis == 0 else gains.integral_gain_y
        before = step.integral[axis]
        if step.settling[0] == 0:
            error = clip(step.speed[axis] - before - stride_mean, gains.largest_error)
            step.integral[axis] = clip(before + gain * error, gains.integral_limit)
        elif settled:
            step.integral[axis] -= step.learnt[axis]
        step.learnt[axis] = step.integral[axis] - before if step.settling[0] == 0 else 0.0
        step.stride_mean[axis] = stride_mean
        step.last_mean_velocity[axis] = mean
        step.velocity_sum[axis] = 0.0
        step.position_sum[axis] = 0.0
        if step.station_kept[0] == 0:
            step.station[axis] = 0.5 * (place + step.last_position[axis])
        step.last_position[axis] = place
    step.velocity_ticks[0] = 0
    step.settling[0] = max(step.settling[0] - 1, 0)
