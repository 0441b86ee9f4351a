"""Step time adapted within the step: a foothold out of reach is met earlier, where it is still near.

The divergent component grows by e^{ωt}: the sooner the foot lands, the nearer is the foothold that catches it. In a
tick whose foothold leaves its comfortable bounds, candidate durations are compared by three costs: shortening the step,
missing the foothold, and a swing foot too far away to get there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from gaitsmith.compiled import Vector, kernel
from gaitsmith.template.foothold import FootholdGains, Forecast, clip, pendulum_frequency
from gaitsmith.template.step import GaitInputs, StepState

_CANDIDATES = 24
_TIME, _FREEZE = 0.36, 0.18  # of 1/ω: shortening that costs 1; before the end the duration stays
_LENGTH = 0.04  # of z: miss that costs 1
_COMFORT = 0.6  # of reach and spread
_RATE = 5.0  # s/s, fastest change of the duration


class StepTimeGains(NamedTuple):
    """:class:`StepTimeParameters` as a kernel reads them."""

    shortest: float
    foot_speed: float


@kernel
def _miss(
    step: StepState,
    gait: GaitInputs,
    gains: FootholdGains,
    times: StepTimeGains,
    forecast: Forecast,
    velocity: Vector,
    foot: Vector,
    side: float,
    left: float,
) -> float:
    """Cost of landing ``left`` seconds from now: the foothold missed, and the way that the foot does not get there.

    Args:
        step: its ``speed`` is v.
        gait: latched.
        gains: of the foothold; the next step takes the nominal period.
        times: least duration and foot speed.
        forecast: its ``arm`` is the CoM relative to the stance sole now, m.
        velocity: (2,) of the CoM, m/s.
        foot: (2,) swing sole relative to the CoM now, m.
        side: +1 if the swing leg is the left one.
        left: s.
    """
    omega = pendulum_frequency(gains, forecast.arm[2])
    nominal = step.duration_ratio[0] * gait.period[0]
    half = 0.5 * omega * nominal
    gain = 1.0 / (omega * math.tanh(2.0 * half))
    grow, shrink = math.exp(omega * left), math.exp(-omega * left)
    carry, rise = 0.5 * (grow + shrink), 0.5 * (grow - shrink)
    unit = _LENGTH * forecast.arm[2]
    cost = way = 0.0
    for axis in range(2):
        arm = carry * forecast.arm[axis] + rise * velocity[axis] / omega
        speed = carry * velocity[axis] + omega * rise * forecast.arm[axis]
        wanted = half / math.tanh(half) * step.speed[axis]
        target = 0.5 * nominal * step.speed[axis]
        if axis == 1:
            wanted += gains.sway * side * omega * gait.width[0] * math.tanh(half)
            target += side * gait.width[0]
        target += gain * (speed - wanted)
        if axis == 0:
            kept = clip(target, min(_COMFORT * gains.reach + 0.5 * nominal * abs(step.speed[0]), gains.reach))
        else:
            kept = clip(target, _COMFORT * gains.spread)
            if side * (kept + arm) < gains.separation:
                kept = side * gains.separation - arm
        cost += ((target - kept) / unit) ** 2
        way += (kept - foot[axis] + arm - forecast.arm[axis]) ** 2
    late = max(math.sqrt(way) - times.foot_speed * left, 0.0)
    return float(cost + (late / unit) ** 2)


@kernel
def adapt_duration(
    step: StepState,
    gait: GaitInputs,
    gains: FootholdGains,
    times: StepTimeGains,
    forecast: Forecast,
    velocity: Vector,
    foot: Vector,
    side: float,
    dt: float,
) -> None:
    """Choose this step's period, and advance the place on the nominal curves so that they end with it."""
    omega = pendulum_frequency(gains, forecast.arm[2])
    ratio, now = step.duration_ratio[0], step.time[0]
    left = ratio * step.period[0] - now
    freeze = _FREEZE / omega
    if times.shortest < 1.0 and left > freeze:
        longest = ratio * gait.period[0]
        best = longest
        cost = _miss(step, gait, gains, times, forecast, velocity, foot, side, longest - now)
        if cost > 1e-6:
            shortest = min(max(times.shortest * longest, now + freeze), longest)
            for k in range(_CANDIDATES):
                duration = shortest + (longest - shortest) * k / _CANDIDATES
                found = _miss(step, gait, gains, times, forecast, velocity, foot, side, duration - now)
                found += ((longest - duration) * omega / _TIME) ** 2
                if found < cost:
                    best, cost = duration, found
        step.period[0] += clip(best / ratio - step.period[0], _RATE * dt)
    remaining = step.period[0] - now + dt
    if remaining > dt:
        step.rate[0] = max(gait.period[0] - step.place[0], 0.0) / remaining
        step.place[0] += step.rate[0] * dt
    else:
        step.rate[0] = 1.0
        step.place[0] += dt
