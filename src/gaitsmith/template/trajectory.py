"""Leg trajectories of the gait template (Han 2023, eqs. 7-12 and 14), evaluated online.

Positions are soles relative to the hip midpoint in the heading frame. Every curve is the two-quartic pair of
eqs. 1-6 with the knots of eq. 14: 0, αT and T.
"""

from __future__ import annotations

from gaitsmith.compiled import Matrix, Vector, kernel
from gaitsmith.splines.quartic_pair import evaluate_pair
from gaitsmith.template.step import Gait, StepState


@kernel
def support_height(step: StepState, gait: Gait, out: Vector) -> None:
    """Desired z of the support sole (Han 2023, eq. 7).

    It starts from the desired state at the switch (section 2.2, first rule) and reaches ``-H`` at T, so a change
    of height is smoothed over one step.

    Args:
        out: (3,) position, velocity, acceleration.
    """
    period = gait.period[0]
    start = step.support_start
    height = -gait.height[0]
    middle = start[0, 2] + gait.alpha[0] * (height - start[0, 2])
    evaluate_pair(
        step.time[0],
        gait.alpha[0] * period,
        period,
        start[0, 2],
        start[1, 2],
        start[2, 2],
        middle,
        height,
        0.0,
        0.0,
        out,
    )


@kernel
def swing_foot(
    step: StepState, gait: Gait, foothold: Vector, ground: float, descent_speed: float, scratch: Vector, out: Matrix
) -> None:
    """Desired state of the swing sole (Han 2023, eqs. 10-12) towards a foothold that may move during the step.

    It starts from the actual state at the switch (section 2.2, second rule). Past T the sole goes on downwards
    until it meets the ground.

    Args:
        foothold: (2,) target x and y, m.
        ground: z of the ground below the foothold, m (negative).
        descent_speed: downward speed past T, m/s.
        scratch: (3,).
        out: (3, 3) position, velocity, acceleration by rows.
    """
    period = gait.period[0]
    middle_time = gait.alpha[0] * period
    time = step.time[0]
    for axis in range(3):
        start = step.swing_start[0, axis]
        if axis < 2:
            end = foothold[axis]
            middle = 0.5 * (start + end)
        else:
            end = ground
            middle = ground + gait.lift[0]
        evaluate_pair(time, middle_time, period, start, step.swing_start[1, axis], 0.0, middle, end, 0.0, 0.0, scratch)
        for order in range(3):
            out[order, axis] = scratch[order]
    if time > period:
        out[0, 2] -= descent_speed * (time - period)
        out[1, 2] = -descent_speed
