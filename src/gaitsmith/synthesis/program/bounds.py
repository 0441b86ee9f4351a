"""Physical constraints (7)-(11) and stability (12)-(14) of a phase, as bounds on linear forms of a point's numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.layout import Layout
from gaitsmith.synthesis.motions.motion import Motion, Phase
from gaitsmith.synthesis.motions.settings import Bounds

Array = npt.NDArray[np.float64]
Form = dict[int, float]
Reach = tuple[float, float, float]
_FACETS = 8  # of the pyramid inside the friction cone
_LEVEL = 0.6  # largest sine of a turning foot's pitch


@dataclass(frozen=True)
class Bound:
    """low <= out·o + inp·z + constant - rise * profile(s) <= high, in ``unit``.

    ``span`` is the range that violations are relative to; s runs from 0 to 1 over the phase. An ``interior`` bound
    does not hold at the phase's ends. With ``sine`` the form is the sine of the angle that is bounded.
    """

    name: str
    unit: str
    out: Form
    inp: Form
    low: float
    high: float
    span: float
    constant: float = 0.0
    interior: bool = False
    rise: float = 0.0
    lifts: bool = False
    lands: bool = False
    sine: bool = False

    def shown(self, value: float) -> float:
        """A value as reports tell it: the angle where the form is a sine."""
        return shown(value, self.sine)

    def offset(self, s: Array) -> Array | float:
        """What is added to the linear form at normalised times (N,): the constant less the risen profile."""
        if not self.rise:
            return self.constant
        s = np.asarray(s, dtype=np.float64)
        up = _smooth(2.0 * s if self.lands else s) if self.lifts else np.ones_like(s)
        down = _smooth(2.0 * (1.0 - s) if self.lifts else 1.0 - s) if self.lands else np.ones_like(s)
        return np.asarray(self.constant - self.rise * np.minimum(up, down))


def shown(value: float, sine: bool) -> float:
    """An angle from its sine, any other value as it is."""
    return float(np.arcsin(np.clip(value, -1.0, 1.0))) if sine else value


def unit_of(quantity: str) -> str:
    """Unit in which reports tell one of the quantities of a motion."""
    kind, _, what = quantity.partition("_")
    if what in ("pitch", "roll", "yaw"):
        return "rad"
    return "m/s" if kind == "ankle" and what.startswith("v") else "m"


def _smooth(s: Array) -> Array:
    """From 0 to 1 with two derivatives zero at both ends, as a foot leaves the ground."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 + s * (6.0 * s - 15.0)))


def pivot_of(biped: Biped, phase: Phase) -> Array:
    """(3,) point of the other sole, in its frame, about which u is taken and which closure holds in place."""
    sole = biped.leg("left").sole
    return np.array([{"heel": -sole.heel, "toe": sole.toe}.get(phase.contact, 0.0), 0.0, 0.0])


def quantity_form(biped: Biped, phase: Phase, quantity: str) -> tuple[Form, float]:
    """Linear form in the outputs, and the constant, that give a quantity in world coordinates."""
    layout, sole = Layout(biped.joints), biped.leg("left").sole
    x0, y0 = phase.foothold
    pivot = pivot_of(biped, phase)[0]
    side = phase.side
    axis = {"x": 0, "y": 1, "z": 2}.get(quantity[-1], 0)
    origin, sign = ((x0, 1.0), (y0, side), (0.0, 1.0))[axis]
    kind, _, what = quantity.partition("_")
    if kind == "ankle" and what.startswith("v"):
        return {layout.ankle_velocity + axis: sign}, 0.0
    if kind == "ankle":
        return {layout.ankle + axis: sign}, origin
    if kind in ("sole", "toe", "heel"):
        reach = {"sole": 0.0, "toe": sole.toe, "heel": -sole.heel}[kind] - pivot
        along = (layout.foot_forward, layout.foot_yaw, layout.foot_pitch)[axis]
        turn = -1.0 if axis == 2 else sign
        return ({layout.pivot + axis: sign} | ({along: turn * reach} if reach else {})), origin
    name = quantity
    flips = -1.0 if name.endswith(("roll", "yaw")) and side < 0 else 1.0
    return {getattr(layout, name): flips}, 0.0


def _sine(name: str, form: Form, low: float, high: float, span: float, interior: bool = False) -> Bound:
    """A bound on an angle through its sine."""
    return Bound(name, "rad", form, {}, low, high, span, interior=interior, sine=True)


def _cone(layout: Layout, what: str, other: bool, scale: float, bounds: Bounds, reach: Reach) -> list[Bound]:
    """Friction, CoP and yaw-moment bounds of the wrench on the support sole, or on the other one.

    ``reach``: how far the CoP may go back, forward, and to a side, m; forces relative to ``scale``.
    """
    first = layout.wrench if other else layout.force
    twist, load = layout.twist + other, layout.load + other

    def bound(name: str, unit: str, wrench: Form, span: float, out: Form | None = None) -> Bound:
        """An upper bound of 0; ``wrench`` holds the six numbers' factors."""
        scaled = {first + index: value / scale for index, value in wrench.items()}
        outs = {index: value / scale for index, value in (out or {}).items()}
        both = (outs, scaled) if other else (outs | scaled, {})
        return Bound(f"{what} {name}", unit, *both, -np.inf, 0.0, span)

    fx, fy, fz, mx, my = range(5)
    back, ahead, aside = reach
    yaw = bounds.yaw_friction
    found = []
    for k in range(_FACETS):
        angle = 2.0 * np.pi * (k + 0.5) / _FACETS
        inner = bounds.friction * np.cos(np.pi / _FACETS)
        found.append(bound("friction", "weights", {fx: np.cos(angle), fy: np.sin(angle), fz: -inner}, 1.0))
    if ahead + back > 0.0:
        found.append(bound("ZMP forward", "m", {my: -1.0, fz: -ahead}, ahead + back))
        found.append(bound("ZMP backward", "m", {my: 1.0, fz: -back}, ahead + back))
    found.append(bound("ZMP left", "m", {mx: 1.0, fz: -aside}, 2.0 * aside))
    found.append(bound("ZMP right", "m", {mx: -1.0, fz: -aside}, 2.0 * aside))
    # About the centre of pressure, times the normal force: a polynomial, without a division at lift-off.
    found.append(bound("yaw moment", "m", {}, 2.0 * yaw, {twist: 1.0, load: -yaw}))
    found.append(bound("yaw moment", "m", {}, 2.0 * yaw, {twist: -1.0, load: -yaw}))
    return found


def _joint_bounds(biped: Biped, bounds: Bounds, phase: Phase) -> list[Bound]:
    layout, robot = Layout(biped.joints), biped.robot
    found = []
    for local in range(biped.joints):
        mirrored = phase.side < 0
        joint = int(biped.partner[local]) if mirrored else local
        sign = float(biped.sign[joint]) if mirrored else 1.0
        name = robot.joint_names[joint]
        torque, speed = (
            float(robot.torque_limit[joint]) * bounds.torque,
            float(robot.velocity_limit[joint]) * bounds.velocity,
        )
        low, high = float(robot.position_low[joint]), float(robot.position_high[joint])
        found.append(Bound(f"{name} torque", "N·m", {layout.torque + local: sign}, {}, -torque, torque, 2 * torque))
        found.append(Bound(f"{name} angle", "rad", {}, {layout.position + local: sign}, low, high, high - low))
        found.append(Bound(f"{name} velocity", "rad/s", {}, {layout.velocity + local: sign}, -speed, speed, 2 * speed))
    return found


def _foot_bounds(biped: Biped, bounds: Bounds, phase: Phase, lifts: bool, lands: bool) -> list[Bound]:
    layout, sole = Layout(biped.joints), biped.leg("left").sole
    length = sole.heel + sole.toe
    if phase.contact == "flat":
        return []
    if phase.contact in ("heel", "toe"):
        low, high = (-_LEVEL, 0.0) if phase.contact == "heel" else (0.0, _LEVEL)
        return [_sine("foot pitch", {layout.foot_pitch: 1.0}, low, high, 1.0, interior=True)]
    found = []
    for x in (-sole.heel, sole.toe):
        for y in (-sole.half_width, sole.half_width):
            form = {layout.pivot + 2: 1.0, layout.foot_pitch: -x, layout.foot_roll: y}
            rise = bounds.clearance
            found.append(Bound("swing clearance", "m", form, {}, 0.0, np.inf, length, 0.0, True, rise, lifts, lands))
    tilt = float(np.sin(bounds.foot_tilt))
    pitch = float(np.sin(bounds.foot_pitch))
    found.append(_sine("swing foot pitch", {layout.foot_pitch: 1.0}, -pitch, pitch, 2 * pitch))
    found.append(_sine("swing foot roll", {layout.foot_roll: 1.0}, -tilt, tilt, 2 * tilt))
    found.append(_sine("swing foot yaw", {layout.foot_yaw: 1.0}, -tilt, tilt, 2 * tilt))
    gap = 2.0 * sole.half_width + bounds.foot_gap
    found.append(Bound("foot separation", "m", {layout.pivot + 1: 1.0}, {}, gap, np.inf, biped.width))
    return found


def check_margin(biped: Biped, bounds: Bounds) -> None:
    """Refuse a ZMP margin that leaves nothing of the sole.

    Raises:
        BadInput: the margin is at least half of the sole's width or length.
    """
    sole = biped.leg("left").sole
    widest = min(sole.half_width, (sole.heel + sole.toe) / 2.0)
    if bounds.zmp_margin >= widest:
        raise BadInput("zmp_margin", bounds.zmp_margin, f"less than {widest:g} m, half of this robot's sole")


def phase_bounds(biped: Biped, bounds: Bounds, motion: Motion, index: int) -> list[Bound]:
    """Every bound that holds throughout a phase, in the phase's local frame as the layout defines it."""
    phase = motion.phases[index]
    layout, sole = Layout(biped.joints), biped.leg("left").sole
    margin = bounds.zmp_margin
    ends = 0.0 if phase.double else margin
    reach = (sole.heel - ends, sole.toe - ends, sole.half_width - margin)
    found = _joint_bounds(biped, bounds, phase)
    found += _cone(layout, f"{phase.support} foot", False, biped.weight, bounds, reach)
    least = 0.0 if phase.double else bounds.normal_force
    scaled = {layout.force + 2: 1.0 / biped.weight}
    found.append(Bound(f"{phase.support} foot normal force", "weights", scaled, {}, least, np.inf, 1.0))
    if phase.double:
        edge = phase.contact != "flat"
        reach = (0.0 if edge else sole.heel, 0.0 if edge else sole.toe, sole.half_width - margin)
        other = "left" if phase.support == "right" else "right"
        found += _cone(layout, f"{other} foot", True, biped.weight, bounds, reach)
        scaled = {layout.wrench + 2: 1.0 / biped.weight}
        found.append(Bound(f"{other} foot normal force", "weights", {}, scaled, 0.0, np.inf, 1.0))
    found.append(
        Bound("squat", "m", {layout.hip_height: 1.0}, {}, 0.3 * biped.height, biped.height - bounds.squat, biped.height)
    )
    for name in ("pitch", "roll", "yaw"):
        tilt = float(np.sin(getattr(bounds, f"torso_{name}")))
        form = {int(getattr(layout, f"torso_{name}")): 1.0}
        found.append(_sine(f"torso {name}", form, -tilt, tilt, 2 * tilt))
    found += _foot_bounds(biped, bounds, phase, motion.lifts(index), motion.lands(index))
    for limit in phase.limits:
        form, constant = quantity_form(biped, phase, limit.quantity)
        unit = unit_of(limit.quantity)
        within = (limit.low, limit.high, biped.height, constant)
        found.append(Bound(limit.quantity, unit, form, {}, *within, sine=unit == "rad"))
    return found
