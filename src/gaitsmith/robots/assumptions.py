"""What a card does not say: from the model, or assumed for a robot of this size; every assumption is a note.

Lengths are in units of the leg or of z, the height of the centre of mass when standing, times in 1/ω = √(z/g), speeds
in U = √(g z), torques in m g times the leg.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from gaitsmith.errors import BadInput
from gaitsmith.robots.card import CardText, Described, JointLimits, RobotCard
from gaitsmith.robots.model_file import ModelFile, listed
from gaitsmith.robots.parameters import GaitLimits, GaitParameters, gait_numbers
from gaitsmith.robots.reach import heights
from gaitsmith.robots.robot import Leg

STRAIGHT = 0.95  # height of the hips, of the straight leg
LEAST_COM = 0.3  # least height of the centre of mass, of the hips'
PERIODS = (1.0, 1.5, 2.4)  # shortest, usual and longest step, in 1/ω
LIFTS = (0.03, 0.09, 0.25)  # in z
HEIGHTS = (0.65, 0.98)  # of the straight leg
WIDTHS = (0.7, 1.8)  # of the usual width
GAP = 0.025  # between the feet and the middle, in z
SPEEDS = ((-0.2, 0.4), (-0.15, 0.15))  # forward, left; in U
TURN = 0.17  # rad per 1/ω
VELOCITY = 4.0  # of a joint, in √(g/leg)
TORQUES = (0.7, 0.2)  # of a joint in the legs, outside; in m g leg
PLACEHOLDER = 2.0  # in m g leg, beyond which a torque limit limits nothing
UPRIGHT = 0.5  # cosine; an axis nearer to the vertical than 60 degrees turns the leg
NEAR = 0.02  # of the straight leg
SLACK = 1e-6


@dataclass(frozen=True)
class Size:
    """A robot's size, as far as its model gives it.

    Attributes:
        mass: kg.
        gravity: m/s².
        leg: hip to sole with straight legs, the shorter leg's, m.
        height: of the centre of mass above the soles when standing, m.
        hip: half the distance of the hips, m.
        half_width: of the wider sole, m.
        turns: whether both legs can turn about the vertical above the knee.
    """

    mass: float
    gravity: float
    leg: float
    height: float
    hip: float
    half_width: float
    turns: bool


def measured(model: mujoco.MjModel, card: Described, legs: Sequence[Leg]) -> Size:
    """Size of a robot, its joint angles zero."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    torso = model.body(card.torso).id
    rotation = data.xmat[torso].reshape(3, 3)
    reaches, turns = [], []
    for leg in legs:
        names = [model.joint(name).id for name in leg.joints]
        anchors = [rotation.T @ (data.xanchor[joint] - data.xpos[torso]) for joint in names]
        sole = rotation.T @ (data.site_xpos[model.site(leg.sole_site).id] - data.xpos[torso])
        knee, ankle = (names.index(joint + 1) for joint in (leg.knee, leg.ankle_pitch))
        bones = np.linalg.norm(anchors[knee] - anchors[knee - 1]) + np.linalg.norm(anchors[ankle] - anchors[knee])
        reaches.append(float(anchors[0][2] - anchors[knee - 1][2] + bones + anchors[ankle][2] - sole[2]))
        turns.append(any(abs(rotation.T @ data.xaxis[joint])[2] > UPRIGHT for joint in names[:knee]))
    hips = np.array([leg.hip_anchor for leg in legs])
    above = float((rotation.T @ (data.subtree_com[torso] - data.xpos[torso]))[2] - hips[:, 2].mean())
    reach = min(reaches)
    return Size(
        mass=float(model.body_mass.sum()),
        gravity=float(np.linalg.norm(model.opt.gravity)),
        leg=reach,
        height=max(STRAIGHT * reach + above, LEAST_COM * abs(reach)),
        hip=float(abs(hips[0, 1] - hips[1, 1])) / 2.0,
        half_width=max(leg.sole.half_width for leg in card.legs),
        turns=all(turns),
    )


def completed(
    card: CardText, found: ModelFile, model: mujoco.MjModel, legs: Sequence[Leg], label: str, notes: list[str]
) -> RobotCard:
    """The card with every entry filled in.

    Args:
        card: as written.
        found: its model.
        model: the same, compiled with what the card adds.
        legs: left, right.
        label: what errors begin with.
        notes: receives what was assumed.

    Raises:
        BadInput: a limit wider than the model's without ``trust``, an unknown joint, heights out of reach.
    """
    names = tuple(model.joint(joint).name for joint in range(1, model.njnt))
    size = measured(model, card, legs)
    if not size.leg > 0.0:
        raise BadInput(f"{label}: legs", f"{size.leg:.4g} m from hip to sole", "soles below the hips")
    for name in card.limits:
        if name not in found.home:
            raise BadInput(f"{label}: limits.{name}", name, f"a joint of the model: {listed(names)}")
    limits = _limits(card, found, size, names, label, notes)
    reached = heights(model, legs, limits, size.leg, _width(size)) or (0.0, size.leg)
    gait, ranges = _gait(card, size, reached, label, notes)
    given = {name: getattr(card, name) for name in Described.model_fields}
    try:
        return RobotCard(**given, mass=size.mass, limits=limits, gait=gait, gait_limits=ranges)
    except BadInput as error:
        raise error.within(label) from None


def _limits(
    card: CardText, found: ModelFile, size: Size, names: Sequence[str], label: str, notes: list[str]
) -> dict[str, JointLimits]:
    """Limits of every joint: the card's, within the model's, else the model's, else assumed."""
    inside = {name for leg in card.legs for name in leg.joints}
    unit = size.mass * size.gravity * size.leg
    speed = VELOCITY * math.sqrt(size.gravity / size.leg)
    limits: dict[str, JointLimits] = {}
    assumed: dict[tuple[str, Any], list[str]] = {}
    wide = []
    for name in names:
        own, given = found.limits[name], card.limits.get(name)
        field = f"{label}: limits.{name}"
        values: dict[str, Any] = {}
        fallback = {"position": (-math.pi, math.pi), "velocity": speed, "torque": TORQUES[name not in inside] * unit}
        for entry, least in fallback.items():
            model, wanted = getattr(own, entry), getattr(given, entry, None)
            if wanted is not None and model is not None and card.trust is None:
                _within(f"{field}.{entry}", wanted, model)
            values[entry] = next(value for value in (wanted, model, least) if value is not None)
            if wanted is None and model is None:
                assumed.setdefault((entry, least), []).append(name)
        if own.torque is not None and own.torque > PLACEHOLDER * unit and values["torque"] == own.torque:
            wide.append(name)
        limits[name] = JointLimits(**values)
    for (entry, value), joints in assumed.items():
        shown = f"{value[0]:.4g} to {value[1]:.4g}" if isinstance(value, tuple) else f"{value:.4g}"
        which = "every joint" if len(joints) == len(names) else listed(joints)
        notes.append(f"assumed, the model gives none: {entry} limit {shown} of {which}")
    if wide:
        notes.append(f"torque limits above {PLACEHOLDER:g} m g times the leg's length, placeholders?: {listed(wide)}")
    return limits


def _within(field: str, wanted: Any, model: Any) -> None:
    """Refuse a limit that is wider than the model's."""
    remedy = 'say trust = "card" in the card if the model is wrong'
    if isinstance(model, tuple):
        if wanted[0] < model[0] - SLACK or wanted[1] > model[1] + SLACK:
            raise BadInput(field, list(wanted), f"a range within the model's, {model[0]:.6g} to {model[1]:.6g}", remedy)
    elif wanted > model * (1.0 + SLACK):
        raise BadInput(field, wanted, f"at most the model's {model:.6g}", remedy)


def _width(size: Size) -> float:
    return max(size.hip, size.half_width + GAP * size.height)


def _gait(
    card: CardText, size: Size, reached: tuple[float, float], label: str, notes: list[str]
) -> tuple[GaitParameters, GaitLimits]:
    """Default gait and its limits: the card's where it gives some, else scaled with the robot."""
    z = size.height
    rate, speed = math.sqrt(size.gravity / z), math.sqrt(size.gravity * z)
    width = _width(size)
    turn = TURN * rate if size.turns else 0.0
    usual: dict[str, Any] = {
        "speed": (0.0, 0.0),
        "period": PERIODS[1] / rate,
        "alpha": 0.5,
        "height": STRAIGHT * size.leg,
    }
    usual |= {"lift": LIFTS[1] * z, "width": width, "yaw_rate": 0.0}
    ranges: dict[str, Any] = {
        "speed_x": tuple(share * speed for share in SPEEDS[0]),
        "speed_y": tuple(share * speed for share in SPEEDS[1]),
        "period": (PERIODS[0] / rate, PERIODS[2] / rate),
        "alpha": (0.2, 0.8),
        "height": (max(HEIGHTS[0] * size.leg, reached[0]), min(HEIGHTS[1] * size.leg, reached[1])),
        "lift": (LIFTS[0] * z, LIFTS[2] * z),
        "width": (WIDTHS[0] * width, WIDTHS[1] * width),
        "yaw_rate": (0.0 - turn, turn),
    }
    given = card.gait.model_dump(exclude_none=True)
    limited = card.gait_limits.model_dump(exclude_none=True)
    for part, _, value in gait_numbers(given):
        low, high = ranges[part]
        if part != "yaw_rate" or size.turns:
            ranges[part] = (min(low, value), max(high, value))
    longest = ranges["period"][1]
    ranges |= limited
    if limited.get("period", (0.0, 0.0))[1] > longest * (1.0 + SLACK):
        notes.append(f"gait_limits.period: no steps longer than {longest:.3g} s are known to be survived")
    low, high = limited.get("height", reached)
    if low < reached[0] - NEAR * size.leg or high > reached[1] + NEAR * size.leg:
        notes.append(f"gait_limits.height: soles are flat from {reached[0]:.3g} to {reached[1]:.3g} m only")
    for name, value in usual.items():
        if name not in given and name != "speed":
            given[name] = min(max(value, ranges[name][0]), ranges[name][1])
    if not ranges["height"][1] < size.leg:
        valid = f"less than {size.leg:.4g}, hip to sole with straight legs"
        raise BadInput(f"{label}: gait_limits.height[1]", ranges["height"][1], valid)
    if any(ranges["yaw_rate"]) and not size.turns:
        valid = "[0, 0]: no joint of this leg above the knee turns about the vertical"
        raise BadInput(f"{label}: gait_limits.yaw_rate", list(ranges["yaw_rate"]), valid)
    return GaitParameters(**given), GaitLimits(**ranges)
