"""Leg trajectories of the gait template (Han 2023, eqs. 7-12 and 14), evaluated online.

Positions are soles relative to the hip midpoint in the heading frame. Every curve is the two-quartic pair of
eqs. 1-6 with the knots of eq. 14: 0, αT and T.
"""

from __future__ import annotations

from typing import NamedTuple

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.splines.quartic_pair import evaluate_pair
from gaitsmith.template.step import GaitInputs, StepState


class Printed(NamedTuple):
    """:class:`PrintedParameters` as a kernel reads them: 1 for what is taken as printed."""

    support_height: float
    support_place: float
    swing_via: float
    swing_frame: float
    swing_feedback: float
    joint_reference: float


@kernel
def support_foot(
    step: StepState,
    gait: GaitInputs,
    printed: Printed,
    height: float,
    side: float,
    scratch: Vector,
    out: Matrix,
) -> None:
    """Desired state of the support sole (Han 2023, eqs. 7-9), from the desired one at the switch (section 2.2).

    z reaches ``-height`` at T, or at αT as printed. x and y are curves only where they are taken as printed.

    Args:
        step: the step being taken.
        gait: latched.
        printed: what is taken as printed.
        height: of the hip midpoint at T, m.
        side: +1 if the support leg is the left one.
        scratch: (3,).
        out: (3, 3) position, velocity, acceleration by rows; x and y are kept without ``support_place``.
    """
    period, alpha, start = gait.period[0], gait.alpha[0], step.support_start
    for axis in range(3):
        if axis == 2:
            end = -height
            middle = end if printed.support_height == 1.0 else start[0, 2] + alpha * (end - start[0, 2])
        elif printed.support_place == 0.0:
            continue
        else:
            end = -0.5 * period * step.speed[0] if axis == 0 else side * gait.width[0]
            middle = 0.0 if axis == 0 else end
        evaluate_pair(
            step.place[0],
            alpha * period,
            period,
            start[0, axis],
            start[1, axis],
            start[2, axis],
            middle,
            end,
            0.0,
            0.0,
            scratch,
        )
        for order in range(3):
            out[order, axis] = scratch[order]


@kernel
def swing_foot(
    step: StepState,
    gait: GaitInputs,
    foothold: Vector,
    ground: float,
    summit: float,
    share: float,
    printed: Printed,
    side: float,
    descent_speed: float,
    scratch: Vector,
    out: Matrix,
) -> None:
    """Desired state of the swing sole (Han 2023, eqs. 10-12) towards a foothold that may move during the step.

    It starts from the actual state at the switch (section 2.2, second rule). Past T the sole goes on downwards
    until it meets the ground.

    Args:
        step: the step being taken.
        gait: latched.
        foothold: (2,) target x and y, m.
        ground: z of the ground below the foothold, m (negative).
        summit: z of the highest ground on the way there, m; the sole is lifted over it.
        share: of the way ahead and aside, by αT; one half on level ground.
        printed: what is taken as printed.
        side: +1 if the swing leg is the left one.
        descent_speed: downward speed past T, m/s.
        scratch: (3,).
        out: (3, 3) position, velocity, acceleration by rows.
    """
    period = gait.period[0]
    joint = gait.alpha[0] * period
    time, rate = step.place[0], step.rate[0]
    for axis in range(3):
        start = step.swing_start[0, axis]
        if axis < 2:
            end = foothold[axis]
            middle = start + share * (end - start)
            if printed.swing_via == 1.0:
                middle = 0.0 if axis == 0 else side * gait.width[0]
        else:
            end = ground
            middle = max(summit, ground) + gait.lift[0]
        evaluate_pair(time, joint, period, start, step.swing_start[1, axis], 0.0, middle, end, 0.0, 0.0, scratch)
        out[0, axis] = scratch[0]
        out[1, axis] = scratch[1] * rate
        out[2, axis] = scratch[2] * rate * rate
    if time > period:
        out[0, 2] -= descent_speed * (time - period)
        out[1, 2] = -descent_speed


@kernel
def follow_foothold(step: StepState, gait: GaitInputs, share: float, rate: float, scratch: Vector, out: Matrix) -> None:
    """Let the swing sole move with a foothold that moves aside, so that it does not trail behind it.

    The curve is linear in its end, ``y(t) = … + b(t) y_end``: its velocity grows by ``b ẏ_end`` and its acceleration by
    ``2 ḃ ẏ_end``.

    Args:
        step: the step being taken.
        gait: latched.
        share: of the way by αT, as in :func:`swing_foot`.
        rate: lateral velocity of the foothold against the hip midpoint, m/s.
        scratch: (3,).
        out: (3, 3) position, velocity, acceleration by rows.
    """
    period = gait.period[0]
    evaluate_pair(step.place[0], gait.alpha[0] * period, period, 0.0, 0.0, 0.0, share, 1.0, 0.0, 0.0, scratch)
    out[1, 1] += scratch[0] * rate
    out[2, 1] += 2.0 * scratch[1] * step.rate[0] * rate


@kernel
def smooth_share(time: float, span: float) -> float:
    """Share from 0 at 0 to 1 at ``span`` with zero slope at both ends."""
    phase = min(time / span, 1.0) if span > 0.0 else 1.0
    return float(phase * phase * (3.0 - 2.0 * phase))


@kernel
def swing_pitch(step: StepState, gait: GaitInputs, slope: float) -> float:
    """Desired pitch of the swing sole: from its pitch at the switch to the ground's during the lifting stage, rad."""
    start = step.swing_pitch_start[0]
    return float(start + smooth_share(step.place[0], gait.alpha[0] * gait.period[0]) * (slope - start))


@kernel
def swing_yaw(step: StepState, gait: GaitInputs) -> float:
    """Desired yaw of the swing sole against the heading: it lands half a step's turn ahead of the torso, rad."""
    period = gait.period[0]
    ahead = gait.yaw_rate[0] * (max(period - step.time[0], 0.0) + 0.5 * period)
    start = step.swing_yaw_start[0]
    return float(start + smooth_share(step.place[0], period) * (ahead - start))
