"""Physical constraints (7)-(11) and stability (12)-(14) of a phase, as bounds on linear forms of a point's numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.contacts import check_slope
from gaitsmith.synthesis.motions.motion import Motion, Phase
from gaitsmith.synthesis.motions.quantities import RATE, of_joint, unit_of
from gaitsmith.synthesis.motions.settings import Bounds
from gaitsmith.synthesis.point.layout import layout_of
from gaitsmith.synthesis.program.quantities import Form, joint_form, quantity_form

Array = npt.NDArray[np.float64]
_FACETS = 8  # of the pyramid inside the friction cone
_LEAST = 0.1  # share of an edge's distance that a margin leaves
_TWIST = 0.5  # share of what friction at both ends of an edge could bear as a yaw moment
_LEVEL = 0.6  # largest sine of a turning foot's pitch


NO_LOAD = -1


class Kind(Enum):
    """What limits a motion: a joint, a contact, or what the request asks for."""

    TORQUE = auto()
    VELOCITY = auto()
    ANGLE = auto()
    FRICTION = auto()
    YAW_MOMENT = auto()
    ZMP = auto()
    NORMAL_FORCE = auto()
    REQUEST = auto()


@dataclass(frozen=True)
class PhaseBound:
    """low <= out·o + inp·z + constant - rise * profile(s) <= high, in ``unit``.

    ``span`` is the range that violations are relative to; s runs from 0 to 1 over the phase. An ``interior`` bound
    does not hold at the phase's ends. With ``sine`` the form is the sine of the angle that is bounded.

    A contact's bound is form <= 0 with form = (ratio - limit) * factor * load**power: ``load`` is the normal force as a
    share of the weight, of the support sole (0) or the other (1); the ratio is the friction coefficient that is needed,
    the place of the ZMP, m, or the lever of the yaw moment, m. Reports show the ratio, and ``span`` is of the form.
    ``slack``: the violation that is accepted on the dense grid.
    """

    kind: Kind
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
    load: int = NO_LOAD
    limit: float = 0.0
    ratio_span: float = 1.0
    factor: float = 1.0
    power: int = 1
    slack: float = 0.0

    def free_at(self, start: bool, end: bool) -> bool:
        """Whether it does not hold at an end of its phase: of a clearance, only where the foot lifts or lands."""
        return self.interior and ((start and (self.lifts or not self.rise)) or (end and (self.lands or not self.rise)))

    def shown(self, value: float) -> float:
        """A value as reports show it: the angle where the form is a sine."""
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


def _smooth(s: Array) -> Array:
    """From 0 to 1 with two derivatives zero at both ends, as a foot leaves the ground."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 + s * (6.0 * s - 15.0)))


def _sine(name: str, form: Form, low: float, high: float, span: float, interior: bool = False) -> PhaseBound:
    """A bound on an angle through its sine."""
    return PhaseBound(Kind.REQUEST, name, "rad", form, {}, low, high, span, interior=interior, sine=True)


def _contact_bounds(biped: Biped, bounds: Bounds, phase: Phase, other: bool, beside: bool = False) -> list[PhaseBound]:
    """Friction, centre of pressure, yaw moment and normal force of the wrench on the support sole, or on the other.

    Forces are relative to the weight. Lengthwise the margin is 0 while both feet bear, and ``beside`` a phase in which
    the foot turns about its edge, because its ZMP is there then.
    """
    layout, weight = layout_of(biped), biped.weight
    cos, sin = (float(f(phase.bend)) if other else x for f, x in ((np.cos, 1.0), (np.sin, 0.0)))
    foot = phase.other_foot if other else phase.support
    first = layout.wrench if other else layout.force
    twist, load = layout.twist + other, layout.load + other
    found: list[PhaseBound] = []

    def add(
        kind: Kind, name: str, unit: str, wrench: Form, span: float, out: Form | None = None, **ratio: float
    ) -> None:
        """An upper bound of 0; ``wrench`` holds the factors of the six numbers in the sole's own axes."""
        own = np.array([wrench.get(index, 0.0) for index in range(6)]).reshape(2, 3)
        turned = (own @ [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]).ravel().tolist()
        scaled = {first + index: value / weight for index, value in enumerate(turned) if value}
        outs = {index: value / weight for index, value in (out or {}).items()}
        both = (outs, scaled) if other else (outs | scaled, {})
        found.append(PhaseBound(kind, f"{foot} foot {name}", unit, *both, -np.inf, 0.0, span, load=int(other)))

    def tell(limit: float, span: float, factor: float = 1.0, power: int = 1) -> None:
        """How the last bound's ratio reads."""
        found[-1] = replace(found[-1], limit=limit, ratio_span=span, factor=factor, power=power)

    fx, fy, fz, mx, my = range(5)
    yaw = bounds.yaw_friction
    inner = float(np.cos(np.pi / _FACETS))
    for k in range(_FACETS):
        angle = 2.0 * np.pi * (k + 0.5) / _FACETS
        form = {fx: np.cos(angle), fy: np.sin(angle), fz: -inner * bounds.friction}
        add(Kind.FRICTION, "friction", "of the load", form, 1.0)
        tell(bounds.friction, bounds.friction, inner)
    sole, ends = biped.sole(foot), 0.0 if phase.double or beside else bounds.zmp_margin
    edges = sole.edges * (1.0, phase.side, 1.0)
    if other and phase.contact != "flat":
        _, right, left = sole.ends[0 if phase.contact == "heel" else 1]
        half = 0.5 * float(left - right)
        edges, yaw = np.array([(0.0, 1.0, half), (0.0, -1.0, half)]), min(yaw, _TWIST * bounds.friction * half)
    if not other and phase.tips:
        _, right, left = sole.ends[1]
        half, middle = 0.5 * float(left - right), phase.side * 0.5 * float(left + right)
        edges = np.array([(0.0, 1.0, half + middle), (0.0, -1.0, half - middle)])
        yaw = min(yaw, _TWIST * bounds.friction * half)
    for x, y, distance in edges.tolist():
        along = abs(x) > abs(y)
        name = ("backward", "forward")[x > 0.0] if along else ("outward", "inward")[(y > 0.0) != other]
        room = max(distance - (ends if along else bounds.zmp_margin), _LEAST * distance)
        span = sole.heel + sole.toe if along else 2.0 * sole.half_width
        add(Kind.ZMP, f"ZMP {name}", "m", {my: -x, mx: y, fz: -room}, span)
        tell(room, span)
    # About the centre of pressure, times the normal force: a polynomial, without a division at lift-off.
    for sign in (1.0, -1.0):
        add(Kind.YAW_MOMENT, "yaw moment", "m", {}, 2.0 * yaw, {twist: sign, load: -yaw})
        tell(yaw, 2.0 * yaw, power=2)
    name = "normal force" if phase.double else "normal force alone"
    add(Kind.NORMAL_FORCE, name, "weights", {fz: 1.0}, 1.0)
    least = 0.0 if phase.double else bounds.normal_force
    found[-1] = replace(found[-1], low=least, high=np.inf, load=NO_LOAD)
    return found


def joint_bounds(biped: Biped, bounds: Bounds, side: float, joints: Sequence[int] | None = None) -> list[PhaseBound]:
    """Torque, angle and velocity of joints, by default of all that move.

    Args:
        biped: the robot.
        bounds: shares of torque and velocity that may be used.
        side: -1 in the mirror image.
        joints: which, in local order.
    """
    layout, robot = layout_of(biped), biped.robot
    found = []
    for local in range(biped.joints) if joints is None else joints:
        place = int(biped.partner[local]) if side < 0 else local
        joint = int(biped.index[place])
        sign = float(biped.sign[place]) if side < 0 else 1.0
        torque = float(robot.torque_limit[joint]) * bounds.torque
        speed = float(robot.velocity_limit[joint]) * bounds.velocity
        angle = float(robot.position_low[joint]), float(robot.position_high[joint])
        for kind, what, unit, first, (low, high) in (
            (Kind.TORQUE, "torque", "N·m", layout.torque, (-torque, torque)),
            (Kind.ANGLE, "angle", "rad", layout.position, angle),
            (Kind.VELOCITY, "velocity", "rad/s", layout.velocity, (-speed, speed)),
        ):
            form: Form = {first + local: sign}
            both = (form, {}) if kind is Kind.TORQUE else ({}, form)
            found.append(PhaseBound(kind, f"{robot.joint_names[joint]} {what}", unit, *both, low, high, high - low))
    return found


def _foot_bounds(biped: Biped, bounds: Bounds, motion: Motion, index: int) -> list[PhaseBound]:
    phase, lifts, lands = motion.phases[index], motion.lifts(index), motion.lands(index)
    layout, sole = layout_of(biped), biped.sole(phase.other_foot)
    length = sole.heel + sole.toe
    if phase.contact == "flat":
        return []
    if phase.contact in ("heel", "toe"):
        low, high = (-_LEVEL, 0.0) if phase.contact == "heel" else (0.0, _LEVEL)
        return [_sine("foot pitch", {layout.foot_pitch: 1.0}, low, high, 1.0, interior=True)]
    found = []
    if phase.tips:
        found.append(_sine("support foot pitch", {layout.own + 4: 1.0}, 0.0, _LEVEL, 1.0, interior=True))
    for x, y in biped.corners("flat", phase.other_foot).tolist():
        form = {layout.pivot + 2: 1.0, layout.foot_pitch: -x, layout.foot_roll: phase.side * y}
        clear = PhaseBound(Kind.REQUEST, "swing clearance", "m", form, {}, 0.0, np.inf, length, interior=True)
        found.append(replace(clear, constant=-phase.rise, rise=bounds.clearance, lifts=lifts, lands=lands))
    tilt = float(np.sin(bounds.foot_tilt))
    pitch = float(np.sin(bounds.foot_pitch))
    found.append(_sine("swing foot pitch", {layout.foot_pitch: 1.0}, -pitch, pitch, 2 * pitch))
    if not biped.lines:
        found.append(_sine("swing foot roll", {layout.foot_roll: 1.0}, -tilt, tilt, 2 * tilt))
    bends = motion.bends(index)
    low, high = _yaws(bends, bounds.foot_tilt)
    found.append(_sine("swing foot yaw", {layout.foot_yaw: 1.0}, low, high, high - low))
    gap = sole.half_width + biped.sole(phase.support).half_width + bounds.foot_gap
    if phase.flies:
        found += _own_bounds(biped, bounds, phase, lifts, lands)
    for end in (sole.toe, -sole.heel) if any(bends) else (0.0,):
        apart = {layout.pivot + 1: 1.0} | ({layout.foot_yaw: end} if end else {})
        apart |= {layout.own + 1: -1.0} if phase.flies else {}
        found.append(PhaseBound(Kind.REQUEST, "foot separation", "m", apart, {}, gap, np.inf, biped.width))
    return found


def _yaws(bends: tuple[float, float], most: float) -> tuple[float, float]:
    """Sines of the angles ``most`` rad beyond a range of headings."""
    quarter = 0.5 * np.pi
    return float(np.sin(max(bends[0] - most, -quarter))), float(np.sin(min(bends[1] + most, quarter)))


def _own_bounds(biped: Biped, bounds: Bounds, phase: Phase, lifts: bool, lands: bool) -> list[PhaseBound]:
    """Of the support sole in flight: above the ground and level, as the other one."""
    layout, sole, found = layout_of(biped), biped.sole(phase.support), list[PhaseBound]()
    yaw, pitch, roll = range(layout.own + 3, layout.own + 6)
    for x, y in biped.corners("flat", phase.support).tolist():
        form = {layout.own + 2: 1.0, pitch: -x, roll: phase.side * y}
        span = sole.heel + sole.toe
        clear = PhaseBound(Kind.REQUEST, "support clearance", "m", form, {}, 0.0, np.inf, span, interior=True)
        found.append(replace(clear, rise=bounds.clearance, lifts=lifts, lands=lands))
    for name, place, most in (("pitch", pitch, "foot_pitch"), ("roll", roll, "foot_tilt"), ("yaw", yaw, "foot_tilt")):
        tilt = float(np.sin(getattr(bounds, most)))
        found.append(_sine(f"support foot {name}", {place: 1.0}, -tilt, tilt, 2 * tilt))
    return found


def check_margin(biped: Biped, bounds: Bounds) -> None:
    """Refuse a ZMP margin that leaves nothing of the sole.

    Raises:
        BadInput: the margin is at least half of the sole's width or length.
    """
    widest = biped.narrowest
    if bounds.zmp_margin >= widest:
        raise BadInput("zmp_margin", bounds.zmp_margin, f"less than {widest:g} m, half of this robot's sole")


def check_roots(biped: Biped, motion: Motion, order: int) -> None:
    """Refuse line soles that turn about their heel or toe or fly, and quartics where a support sole moves.

    Raises:
        BadInput: naming the phase, or the order.
    """
    if order < 5 and (biped.lines or motion.flies or motion.tips):
        valid = "5 for line soles, flights and support feet on their toes"
        raise BadInput("order", order, valid, "their equations of motion need it")
    if motion.tips and (biped.lines or motion.flies):
        index = next(k for k, phase in enumerate(motion.phases) if phase.tips)
        raise BadInput(f"phases[{index}].support_contact", "toe", "flat for line soles, and in motions with flights")
    check_slope(motion)
    if motion.slope and biped.lines:
        raise BadInput("slope", motion.slope, "0 for soles that are lines")
    for index, phase in enumerate(motion.phases):
        if biped.lines and phase.contact in ("heel", "toe", "flight"):
            raise BadInput(f"phases[{index}].contact", phase.contact, "flat or air for a sole that is a line")


def phase_bounds(biped: Biped, bounds: Bounds, motion: Motion, index: int) -> list[PhaseBound]:
    """Every bound that holds throughout a phase, in the phase's local frame as the layout defines it."""
    phase = motion.phases[index]
    layout = layout_of(biped)
    found = joint_bounds(biped, bounds, phase.side)
    if not phase.flies:
        found += _contact_bounds(biped, bounds, phase, False, motion.beside_edge(index))
    if phase.double:
        found += _contact_bounds(biped, bounds, phase, True)
    heights = (0.3 * biped.height, biped.height - bounds.squat, biped.height)
    above = {layout.hip_height: 1.0} | ({layout.own + 2: -1.0} if phase.flies else {})
    found.append(PhaseBound(Kind.REQUEST, "squat", "m", above, {}, *heights))
    bends = motion.bends(index)
    low, high = _yaws((min(bends[0], 0.0), max(bends[1], 0.0)), bounds.torso_yaw)
    found.append(_sine("torso yaw", {layout.torso_yaw: 1.0}, low, high, high - low))
    for name in ("pitch", "roll"):
        most, lean = getattr(bounds, f"torso_{name}"), motion.slope if name == "pitch" else 0.0
        low, high = float(np.sin(lean - most)), float(np.sin(lean + most))
        form = {int(getattr(layout, f"torso_{name}")): 1.0}
        found.append(_sine(f"torso {name}", form, low, high, high - low))
    found += _foot_bounds(biped, bounds, motion, index)
    for limit in phase.limits:
        if limit.quantity == RATE:
            continue  # with the bound on all torque rates: rates.py
        unit = unit_of(limit.quantity)
        if of_joint(limit.quantity) is not None:
            out, inp, span = joint_form(biped, phase, limit.quantity)
            found.append(PhaseBound(Kind.REQUEST, limit.quantity, unit, out, inp, limit.low, limit.high, span))
            continue
        form, constant = quantity_form(biped, phase, limit.quantity)
        within = (limit.low, limit.high, biped.height, constant)
        found.append(PhaseBound(Kind.REQUEST, limit.quantity, unit, form, {}, *within, sine=unit == "rad"))
    return found
