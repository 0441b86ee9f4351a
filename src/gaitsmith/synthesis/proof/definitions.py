"""Every bound as the paper's equations (7)-(14) and docs/synthesis.md state it, on whatever numbers it is given.

The numbers may be NumPy arrays (instants) or Taylor models (all times of a stretch): only sums and products occur.
World axes; lengths in m, forces as shares of the weight where a name says so. Nothing here comes from the planner.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import At, Limit, Motion, Phase, Side
from gaitsmith.synthesis.motions.quantities import RATE, by_sine, of_joint, unit_of
from gaitsmith.synthesis.proof.quantities import Measured, about_toe, along_sole, corner_heights, own_heights, quantity

LOADED = 0.01  # of the weight: what a foot bears at least where ratios of its forces mean something
ROUNDING = 1e-9  # share of a bound's range: the resolution of a file's numbers
GROUND = 1e-6  # m, or the sine of a pitch: to which a sole stands on the ground where its bound begins or ends to hold
CONDITION = 1e-5  # m, m/s or the sine of an angle, of conditions, and of a limit on which one puts the motion
_FACES = 8  # of the pyramid inscribed in the friction cone
_LEVEL = 0.6  # sine of the largest pitch of a foot that turns about an edge
_ENDS = 0.5  # share of the friction at both ends of an edge that may bear a yaw moment
_KEPT = 0.1  # share of an edge's distance from the sole's frame that a ZMP margin leaves
_CROUCH = 0.3  # of the height with straight legs: lowest hips


@dataclass(frozen=True, eq=False)
class Bound:
    """low <= value <= high, violations relative to ``span``.

    A bound on a contact is value <= 0 with value = (ratio - limit) * factor * load**power, where ``ratio`` is the
    friction coefficient needed, the place of the ZMP (m), or the lever of the yaw moment (m), and ``load`` is the
    foot's normal force as a share of the weight: it holds for an unloaded foot too.

    Attributes:
        name: as in the certificate.
        unit: of the ratio or value as shown.
        value: in shares of the weight where forces are bounded.
        low, high, span: of the value; of a contact, the span of the ratio.
        interior: it does not hold at the phase's ends, where the foot is on the ground.
        sine: the value is the sine of the angle that is bounded.
        load, limit, factor, power: of a contact, else None.
        allowed: the largest violation that is none: what a motion meets exactly, it meets to so much.
    """

    name: str
    unit: str
    value: Any
    low: float
    high: float
    span: float
    interior: bool = False
    sine: bool = False
    load: Any = None
    limit: float = 0.0
    factor: float = 1.0
    power: int = 1
    allowed: float = ROUNDING


def phase_bounds(found: Measured, biped: Biped, bounds: dict[str, float], motion: Motion, index: int) -> list[Bound]:
    """Every bound that holds throughout a phase.

    Args:
        found: the phase's numbers.
        biped: the robot with all its joints; the card's limits.
        bounds: of the gait file.
        motion: of the gait file.
        index: of the phase.
    """
    phase = motion.phases[index].straight
    items = [*joint_limits(found, biped, bounds, phase)]
    for foot in () if phase.flies else (phase.support, phase.other_foot) if phase.double else (phase.support,):
        items += _contact(found, biped, bounds, phase, foot, motion.beside_edge(index))
    tall = biped.height
    above = found.hip - (found.own[2] - phase.height) if phase.flies else found.hip
    items.append(Bound("squat", "m", above, _CROUCH * tall, tall - bounds["squat"], tall))  # (7)
    toward = phase.side
    upright = motion.slope  # pitch, against the ground, of a torso that is upright
    items.append(_angle("torso pitch", -found.torso[2, 0], bounds["torso_pitch"], (upright, upright)))
    items.append(_angle("torso roll", found.torso[2, 1] * toward, bounds["torso_roll"]))
    yaws = motion.bends(index)
    feet = min(yaws[0], 0.0), max(yaws[1], 0.0)
    items.append(_angle("torso yaw", found.torso[1, 0] * toward, bounds["torso_yaw"], feet))
    items += _foot(found, biped, bounds, motion, index)
    for limit in phase.limits:
        if limit.quantity == RATE:
            continue  # among the joints' limits
        value, unit = quantity(found, biped, phase, limit.quantity), unit_of(limit.quantity)
        span = range_of(biped, limit.quantity)
        bound = Bound(limit.quantity, unit, value, limit.low, limit.high, span, sine=by_sine(limit.quantity))
        allowed = allowed_of(biped, limit.quantity) / span
        items.append(replace(bound, allowed=allowed) if _meets(limit, motion, index) else bound)
    return items


def _meets(limit: Limit, motion: Motion, index: int) -> bool:
    """Whether a condition at a border of the phase puts the motion on a limit."""
    return any(
        isinstance(item, At)
        and item.quantity == limit.quantity
        and item.border in (index, index + 1)
        and min(abs(item.value - limit.low), abs(item.value - limit.high)) <= CONDITION
        for item in motion.conditions
    )


def range_of(biped: Biped, name: str) -> float:
    """What violations of a limit on a quantity are relative to: the robot's height, or what a joint's card allows."""
    joint, robot = of_joint(name), biped.robot
    if joint is None:
        return biped.height
    k = robot.joint_names.index(joint[0])
    fast = 2.0 * float(robot.velocity_limit[k])
    return {
        "angle": float(robot.position_high[k] - robot.position_low[k]),
        "velocity": fast,
        "acceleration": fast / biped.fall_time,
        "torque": 2.0 * float(robot.torque_limit[k]),
    }[joint[1]]


def allowed_of(biped: Biped, name: str) -> float:
    """By how much a condition on a quantity may be missed."""
    return CONDITION * (1.0 if of_joint(name) is None else max(1.0, range_of(biped, name)))


def joint_limits(found: Measured, biped: Biped, bounds: dict[str, float], phase: Phase) -> Iterator[Bound]:
    """(10), (11): the card's limits, of torque and velocity the share that may be used; how fast torques may change."""
    robot = biped.robot
    for k, name in enumerate(robot.joint_names):
        most = float(robot.torque_limit[k]) * bounds["torque"]
        yield Bound(f"{name} torque", "N·m", found.torque[k], -most, most, 2.0 * most)
        low, high = float(robot.position_low[k]), float(robot.position_high[k])
        yield Bound(f"{name} angle", "rad", found.q[k], low, high, high - low)
        fast = float(robot.velocity_limit[k]) * bounds["velocity"]
        yield Bound(f"{name} velocity", "rad/s", found.v[k], -fast, fast, 2.0 * fast)
        if found.moving[k]:
            asked = [limit.high for limit in phase.limits if limit.quantity == RATE]
            steep = min([bounds["torque_rate"], *asked])
            yield Bound(f"{name} torque rate", "N·m/s", found.rate[k], -steep, steep, 2.0 * steep)


def _angle(name: str, sine: Any, most: float, between: tuple[float, float] = (0.0, 0.0)) -> Bound:
    """An angle at most ``most`` rad outside of two others, through its sine."""
    low, high = (float(np.sin(np.clip(angle, -0.5 * np.pi, 0.5 * np.pi))) for angle in np.add(between, (-most, most)))
    return Bound(name, "rad", sine, low, high, high - low, sine=True)


def sole_edges(biped: Biped, phase: Phase, foot: Side) -> list[tuple[str, float, float, float]]:
    """Edges of the part of a sole that bears in a phase: name, outward normal (x, y), distance from the frame, m.

    Inward is where the other foot is. A foot on an edge bears by two ends, as a flat line sole does.
    """
    if biped.lines:
        sole = biped.sole(foot)
        return [("forward", 1.0, 0.0, sole.toe), ("backward", -1.0, 0.0, sole.heel)]
    corners = biped.corners(phase.support_contact if foot == phase.support else phase.contact, foot)
    inward = 1.0 if foot == "right" else -1.0
    if len(corners) == 2:
        half = 0.5 * float(np.ptp(corners[:, 1]))
        return [("inward" if y * inward > 0.0 else "outward", 0.0, y, half) for y in (1.0, -1.0)]
    found = []
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        length = float(np.hypot(x1 - x0, y1 - y0))
        x, y = float(y1 - y0) / length, float(x0 - x1) / length
        ahead = "forward" if x > 0.0 else "backward"
        aside = "inward" if y * inward > 0.0 else "outward"
        found.append((ahead if abs(x) > abs(y) else aside, x, y, float(x * x0 + y * y0)))
    return found


def _contact(
    found: Measured, biped: Biped, bounds: dict[str, float], phase: Phase, foot: Side, beside: bool
) -> Iterator[Bound]:
    """(12)-(14) of one foot: friction, the ZMP inside the sole, yaw moment about it, and no pull.

    ``beside``: the support foot turns about its edge before or after, so that its ZMP is there then.
    """
    bears = foot == phase.support
    force, moment = (found.force, found.moment) if bears else (found.push, found.turn)
    if bears and phase.tips:
        moment = about_toe(found, biped, phase)
    if not bears:
        force, moment = (along_sole(vector, phase.other_heading) for vector in (force, moment))
    weight, sole = biped.weight, biped.sole(foot)
    fx, fy, fz = (force[k] * (1.0 / weight) for k in range(3))
    mx, my, mz = (moment[k] * (1.0 / weight) for k in range(3))
    friction, yaw = bounds["friction"], bounds["yaw_friction"]

    def ratio(name: str, unit: str, top: Any, limit: float, span: float, factor: float = 1.0, power: int = 1) -> Bound:
        """``top`` is the ratio times factor and load to its power."""
        bottom = fz if power == 1 else fz * fz
        value = top - bottom * (limit * factor)
        return Bound(f"{foot} foot {name}", unit, value, -np.inf, 0.0, span, False, False, fz, limit, factor, power)

    inscribed = float(np.cos(np.pi / _FACES))
    for k in range(_FACES):
        angle = (2.0 * k + 1.0) * np.pi / _FACES
        push = fx * float(np.cos(angle)) + fy * float(np.sin(angle))
        yield ratio("friction", "of the load", push, friction, friction, inscribed)
    edges = sole_edges(biped, phase, foot)
    for name, x, y, distance in edges:
        along = name in ("forward", "backward")
        margin = 0.0 if along and (phase.double or beside) else bounds["zmp_margin"]
        room = max(distance - margin, _KEPT * distance)
        size = sole.heel + sole.toe if along else 2.0 * sole.half_width
        yield ratio(f"ZMP {name}", "m", mx * y - my * x, room, size)
    if phase.tips if bears else phase.contact != "flat":
        yaw = min(yaw, _ENDS * friction * edges[0][3])
    twist = mx * fx + my * fy + mz * fz  # times the load: about the centre of pressure
    for sign in (1.0, -1.0):
        yield ratio("yaw moment", "m", twist * sign, yaw, 2.0 * yaw, power=2)
    name, least = ("normal force", 0.0) if phase.double else ("normal force alone", bounds["normal_force"])
    yield Bound(f"{foot} foot {name}", "weights", fz, least, np.inf, 1.0)


def _foot(found: Measured, biped: Biped, bounds: dict[str, float], motion: Motion, index: int) -> Iterator[Bound]:
    """(8), (9) of the other foot: above the ground, level, and beside the support foot."""
    phase = motion.phases[index].straight
    pitch = -found.rotation[2, 0]
    if phase.contact in ("heel", "toe"):
        low, high = (-_LEVEL, 0.0) if phase.contact == "heel" else (0.0, _LEVEL)
        yield Bound("foot pitch", "rad", pitch, low, high, 1.0, interior=True, sine=True, allowed=GROUND)
    if phase.double:
        return
    if phase.tips:
        own = -found.level[2, 0]
        yield Bound("support foot pitch", "rad", own, 0.0, _LEVEL, 1.0, interior=True, sine=True, allowed=GROUND)
    foot = biped.sole(phase.other_foot)
    rise = found.profile(motion.lifts(index), motion.lands(index)) * bounds["clearance"]
    for height in corner_heights(found, biped, phase):
        size = foot.heel + foot.toe
        yield Bound("swing clearance", "m", height - rise, 0.0, np.inf, size, interior=True, allowed=GROUND / size)
    yaws = motion.bends(index)
    yield _angle("swing foot pitch", pitch, bounds["foot_pitch"])
    if not biped.lines:  # a line may roll about itself
        yield _angle("swing foot roll", found.rotation[2, 1] * phase.side, bounds["foot_tilt"])
    yield _angle("swing foot yaw", found.rotation[1, 0] * phase.side, bounds["foot_tilt"], yaws)
    if phase.flies:
        yield from _flying(found, biped, bounds, motion, index)
    least = foot.half_width + biped.sole(phase.support).half_width + bounds["foot_gap"]
    for x in (foot.toe, -foot.heel) if any(yaws) else (0.0,):  # ends of a sole that turns inward
        aside = found.own[1] if phase.flies else phase.foothold[1]
        apart = (found.pivot[1] - aside + found.rotation[1, 0] * x) * phase.side
        yield Bound("foot separation", "m", apart, least, np.inf, biped.width)


def _flying(found: Measured, biped: Biped, bounds: dict[str, float], motion: Motion, index: int) -> Iterator[Bound]:
    """The same of a support sole that has left the ground."""
    phase, foot = motion.phases[index], biped.sole(motion.phases[index].support)
    rise = found.profile(motion.lifts(index), motion.lands(index)) * bounds["clearance"]
    size = foot.heel + foot.toe
    for height in own_heights(found, biped, phase):
        ground = GROUND / size
        yield Bound("support clearance", "m", height - rise, 0.0, np.inf, size, interior=True, allowed=ground)
    for name, sine, most in (
        ("pitch", -found.level[2, 0], bounds["foot_pitch"]),
        ("roll", found.level[2, 1] * phase.side, bounds["foot_tilt"]),
        ("yaw", found.level[1, 0] * phase.side, bounds["foot_tilt"]),
    ):
        yield _angle(f"support foot {name}", sine, most)
