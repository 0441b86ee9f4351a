"""The paper's motions as data: cyclic (1)-(6), start (21), (22), stop (23), (24), kick (25)-(31)."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import (
    At,
    Condition,
    Limit,
    Motion,
    Phase,
    Same,
    Side,
    State,
    opposite,
)
from gaitsmith.synthesis.motions.parameters import JumpParameters, KickParameters, StepParameters, record

Array = npt.NDArray[np.float64]
Point = tuple[float, float]
_SINGLE, _DOUBLE, _MOST = 2.0, 0.3, 8  # longest sections in the robot's unit of time; most sections of a phase


def sections_of(biped: Biped, duration: float, double: bool) -> int:
    """Spline sections of a phase: short beside the time in which the robot falls, shorter where the chain is closed."""
    short = double or biped.lines  # of lines the leans are to follow the program's closely
    longest = (_DOUBLE if short else _SINGLE) * biped.fall_time
    return min(max(2 if short else 1, math.ceil(duration / longest)), _MOST)


def _swing(biped: Biped, step: StepParameters, support: Side, foothold: Point) -> list[Phase]:
    single = step.period * (1.0 - step.double_support)
    up, down = single * step.swing_split, single * (1.0 - step.swing_split)
    sections = sections_of(biped, 0.5 * single, False)
    return [
        Phase("swing up", up, support, "air", foothold, sections=sections),
        Phase("swing down", down, support, "air", foothold, sections=sections),
    ]


def _transfer(biped: Biped, step: StepParameters, support: Side, foothold: Point, landing: Point) -> list[Phase]:
    double = step.period * step.double_support
    if biped.lines:  # a line that turns about its end is a point, about which nothing keeps the foot from yawing
        sections = sections_of(biped, 0.5 * double, True)
        return [
            Phase("load", 0.5 * double, support, "flat", foothold, landing, sections),
            Phase("unload", 0.5 * double, opposite(support), "flat", landing, foothold, sections),
        ]
    heel, toe = double * step.heel_share, double * step.toe_share
    flat = double - heel - toe
    counts = [sections_of(biped, duration, True) for duration in (heel, flat, toe)]
    return [
        Phase("heel", heel, support, "heel", foothold, landing, counts[0]),
        Phase("flat", flat, support, "flat", foothold, landing, counts[1]),
        Phase("toe", toe, opposite(support), "toe", landing, foothold, counts[2]),
    ]


def _apex(biped: Biped, step: StepParameters, border: int) -> list[At]:
    """(2): the ankle at its highest."""
    return [At(border, "ankle_z", biped.ankle_height + step.height), At(border, "ankle_vz", 0.0)]


def _strike(step: StepParameters, border: int) -> At:
    """(3): pitch of the foot as its heel meets the ground."""
    return At(border, "foot_pitch", -float(np.sin(step.heel_strike)))


def _off(step: StepParameters, border: int) -> At:
    """(1): pitch of the rear foot as its toe leaves the ground."""
    return At(border, "foot_pitch", float(np.sin(step.toe_off)))


def cyclic(biped: Biped, step: StepParameters) -> Motion:
    """One step of the cyclic walk, the right foot as first support; six-point boundary constraints (1)-(6).

    Of a robot that is not its own mirror image two steps.
    """
    half = biped.width / 2.0
    here, there, further = (0.0, -half), (step.length, half), (2.0 * step.length, -half)
    phases = _swing(biped, step, "right", here) + _transfer(biped, step, "right", here, there)
    first, steps = len(phases), 1 if biped.symmetric else 2
    if not biped.symmetric:
        phases += _swing(biped, step, "left", there) + _transfer(biped, step, "left", there, further)
    conditions: list[Condition] = []
    for border in range(0, steps * first, first):
        conditions += _apex(biped, step, border + 1)
        conditions += [] if biped.lines else [_strike(step, border + 2), _off(step, border + first)]
    return Motion(
        "cyclic", tuple(phases), tuple(conditions), cyclic=True, parameters=record("cyclic", step), slope=step.slope
    )


def start(biped: Biped, step: StepParameters, rest: Array, goal: tuple[Array, Array, Array]) -> Motion:
    """From rest to the cyclic walk: weight shift, a step of L_step, a transition step of twice that.

    Args:
        biped: the robot.
        step: of the cyclic walk.
        rest: (n,) q0 of (21).
        goal: the cyclic gait's angles, velocities and accelerations at its start, of (22).
    """
    half, length = biped.width / 2.0, step.length
    right, left, right2 = (0.0, -half), (length, half), (2.0 * length, -half)
    phases = [Phase("weight shift", step.shift, "right", "flat", right, (0.0, half), 2)]
    phases += _swing(biped, step, "right", right) + _transfer(biped, step, "right", right, left)
    second = len(phases)
    phases += _swing(biped, step, "left", left) + _transfer(biped, step, "left", left, right2)
    pitches = () if biped.lines else (_strike(step, 3), _off(step, second), _strike(step, second + 2))
    conditions: tuple[Condition, ...] = (
        State(0, rest, np.zeros_like(rest), np.zeros_like(rest)),
        *_apex(biped, step, 2),
        *_apex(biped, step, second + 1),
        *pitches,
        State(len(phases), *goal),
    )
    return Motion("start", tuple(phases), conditions, parameters=record("start", step), slope=step.slope)


def stop(biped: Biped, step: StepParameters, rest: Array, begin: tuple[Array, Array, Array]) -> Motion:
    """From the cyclic walk to rest: a transition step, a step that closes up, and a weight shift; (23), (24)."""
    half, length = biped.width / 2.0, step.length
    right, left, right2 = (0.0, -half), (length, half), (length, -half)
    phases = _swing(biped, step, "right", right) + _transfer(biped, step, "right", right, left)
    second = len(phases)
    phases += _swing(biped, step, "left", left)
    phases.append(Phase("weight shift", step.shift, "left", "flat", left, right2, 2))
    conditions: tuple[Condition, ...] = (
        State(0, *begin),
        *_apex(biped, step, 1),
        *_apex(biped, step, second + 1),
        *(() if biped.lines else (_strike(step, 2), _off(step, second))),
        State(len(phases), rest, np.zeros_like(rest), np.zeros_like(rest)),
    )
    return Motion("stop", tuple(phases), conditions, parameters=record("stop", step), slope=step.slope)


def kick(biped: Biped, parameters: KickParameters, rest: Array) -> Motion:
    """A kick with the left foot: shift, raise, strike, follow through, return, shift back; (25)-(31).

    q_stable of (26) and (30) is not given by the paper: it is free, the same at both instants, and the bounds of
    single support hold there. (29) is also imposed as a maximum. At the ball the foot is level, so that the toe meets
    it, and moves in the ball's plane y.
    """
    half, p = biped.width / 2.0, parameters
    right, left = (0.0, -half), (0.0, half)
    top = biped.ankle_height + p.height
    within: tuple[Limit, ...] = (Limit("ankle_x", high=p.reach),)
    before = (Limit("ankle_x", high=p.ball[0]),)  # or the foot would push the ball away while it is raised
    d = p.durations
    phases = (
        Phase("shift", d[0], "right", "flat", right, left, 2),
        Phase("raise", d[1], "right", "air", right, sections=2, limits=before),
        Phase("strike", d[2], "right", "air", right, sections=2, limits=before),
        Phase("follow through", d[3], "right", "air", right, sections=2, limits=within),
        Phase("return", d[4], "right", "air", right, sections=3, limits=within),
        Phase("shift back", d[5], "right", "flat", right, left, 2),
    )
    still = np.zeros_like(rest)
    conditions: tuple[Condition, ...] = (
        State(0, rest, still, still),
        State(1, velocity=still),
        At(2, "ankle_z", top),
        State(2, velocity=still),
        At(3, "ankle_x", p.ball[0]),
        At(3, "ankle_y", p.ball[1]),
        At(3, "ankle_vx", p.speed),
        At(3, "foot_pitch", 0.0),
        At(3, "sole_z", p.strike),
        At(4, "ankle_x", p.reach),
        At(4, "ankle_vx", 0.0),
        Same(5, 1),
        State(5, velocity=still),
        State(6, rest, still, still),
    )
    return Motion("kick", phases, conditions, parameters=record("kick", p))


def jump(biped: Biped, parameters: JumpParameters, rest: Array) -> Motion:
    """From rest off the ground with both feet, and down to rest at the same place; the soles are highest half-way."""
    half, p = biped.width / 2.0, parameters
    right, left = (0.0, -half), (0.0, half)
    gravity = biped.weight / biped.robot.mass
    half_flight = p.flight * math.sqrt(2.0 * p.height / gravity)
    count = sections_of(biped, half_flight, True)
    phases = (
        Phase("push off", p.durations[0], "right", "flat", right, left, 6),
        Phase("rise", half_flight, "right", "flight", right, sections=count),
        Phase("fall", half_flight, "right", "flight", right, sections=count),
        Phase("landing", p.durations[1], "right", "flat", right, left, 6),
    )
    still = np.zeros_like(rest)
    conditions: tuple[Condition, ...] = (
        State(0, rest, still, still),
        At(2, "sole_z", p.height),
        At(2, "support_z", p.height),
        State(4, rest, still, still),
    )
    return Motion("jump", phases, conditions, parameters=record("jump", p))
