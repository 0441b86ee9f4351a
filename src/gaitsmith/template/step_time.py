"""Step time adapted within the step: a foothold out of reach is met earlier, where it is still near.

The divergent component grows by e^{ωt}: the sooner the foot lands, the nearer is the foothold that catches it. In a
tick whose foothold leaves its comfortable bounds, candidate durations are compared by three costs: shortening the step,
missing the foothold, and a swing foot too far away to get there.
"""

from __future__ import annotations

import math

from gaitsmith.compiled import kernel
from gaitsmith.template.foothold import clip, pendulum_frequency
from gaitsmith.template.state import Template

_CANDIDATES = 24
_TIME, _FREEZE = 0.36, 0.18  # of 1/ω: shortening that costs 1; before the end the duration stays
_LENGTH = 0.04  # of z: miss that costs 1
_COMFORT = 0.6  # of reach and spread
_RATE = 5.0  # s/s, fastest change of the duration


@kernel
def _miss(g: Template, omega: float, side: float, left: float) -> float:
    """Cost of landing ``left`` seconds from now: the foothold missed, and the way that the foot does not get there.

    Args:
        g: its ``forecast.arm`` is the CoM relative to the stance sole now, ``balance.foot`` the swing sole relative to
            the CoM, m; the next step takes the nominal period.
        omega: of the pendulum, 1/s.
        side: +1 if the swing leg is the left one.
        left: s.
    """
    now, velocity, foot = g.forecast.arm, g.body.frames.com_velocity, g.balance.foot
    speed, gains = g.step.speed, g.foothold
    nominal = g.step.duration_ratio[0] * g.latched.period[0]
    half = 0.5 * omega * nominal
    gain = 1.0 / (omega * math.tanh(2.0 * half))
    grow, shrink = math.exp(omega * left), math.exp(-omega * left)
    carry, rise = 0.5 * (grow + shrink), 0.5 * (grow - shrink)
    unit = _LENGTH * now[2]
    cost = way = 0.0
    for axis in range(2):
        arm = carry * now[axis] + rise * velocity[axis] / omega
        wanted = half / math.tanh(half) * speed[axis]
        target = 0.5 * nominal * speed[axis]
        if axis == 1:
            wanted += gains.sway * side * omega * g.latched.width[0] * math.tanh(half)
            target += side * g.latched.width[0]
        target += gain * (carry * velocity[axis] + omega * rise * now[axis] - wanted)
        if axis == 0:
            kept = clip(target, min(_COMFORT * gains.reach + 0.5 * nominal * abs(speed[0]), gains.reach))
        else:
            kept = clip(target, _COMFORT * gains.spread)
            if side * (kept + arm) < gains.separation:
                kept = side * gains.separation - arm
        cost += ((target - kept) / unit) ** 2
        shift = g.ground.shift[axis] if g.ground.known[0] > 0 else 0.0
        way += (kept + shift - foot[axis] + arm - now[axis]) ** 2
    late = max(math.sqrt(way) - g.times.foot_speed * left, 0.0)
    return float(cost + (late / unit) ** 2)


@kernel
def adapt_duration(g: Template, side: float, dt: float) -> None:
    """Choose this step's period, and advance the place on the nominal curves so that they end with it."""
    step, period = g.step, g.latched.period[0]
    omega = pendulum_frequency(g.foothold, g.forecast.arm[2])
    ratio, now = step.duration_ratio[0], step.time[0]
    left = ratio * step.period[0] - now
    freeze = _FREEZE / omega
    if g.times.shortest < 1.0 and left > freeze:
        longest = ratio * period
        best = longest
        cost = _miss(g, omega, side, longest - now)
        if cost > 1e-6:
            shortest = min(max(g.times.shortest * longest, now + freeze), longest)
            for k in range(_CANDIDATES):
                duration = shortest + (longest - shortest) * k / _CANDIDATES
                found = _miss(g, omega, side, duration - now) + ((longest - duration) * omega / _TIME) ** 2
                if found < cost:
                    best, cost = duration, found
        step.period[0] += clip(best / ratio - step.period[0], _RATE * dt)
    remaining = step.period[0] - now + dt
    if remaining > dt:
        step.rate[0] = max(period - step.place[0], 0.0) / remaining
        step.place[0] += step.rate[0] * dt
    else:
        step.rate[0] = 1.0
        step.place[0] += dt
