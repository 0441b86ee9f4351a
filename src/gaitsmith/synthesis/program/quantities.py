"""What a motion may bound or fix, as linear forms of a point's numbers."""

from __future__ import annotations

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Phase
from gaitsmith.synthesis.motions.quantities import QUANTITIES, of_joint
from gaitsmith.synthesis.point.layout import layout_of

Form = dict[int, float]
_PITCH = 1  # axis of an angle that the mirror image keeps


def quantity_form(biped: Biped, phase: Phase, quantity: str) -> tuple[Form, float]:
    """Linear form in the outputs, and the constant, that give a quantity in the world of :attr:`Phase.straight`."""
    layout, sole, pivot = layout_of(biped), biped.sole(phase.other_foot), biped.pivot(phase)
    part, axis, _ = QUANTITIES[quantity]
    if part in ("foot", "torso"):
        return {getattr(layout, quantity): 1.0 if axis == _PITCH else phase.side}, 0.0
    origin, sign = ((phase.foothold[0], 1.0), (phase.foothold[1], phase.side), (phase.height, 1.0))[axis]
    if part == "hip":
        return {layout.hip_height: 1.0}, 0.0
    if part == "support":
        return {layout.own + 2: 1.0} if layout.poses else {}, phase.height
    moving = {"ankle velocity": layout.ankle_velocity, "centre velocity": layout.momentum}
    if part in moving:
        return {moving[part] + axis: sign}, 0.0
    placed = {"ankle": layout.ankle, "centre": layout.com, "body": layout.body}
    if part in placed:
        return {placed[part] + axis: sign}, origin
    reach = {"sole": 0.0, "toe": sole.toe, "heel": -sole.heel}[part] - float(pivot[0])
    along = (layout.foot_forward, layout.foot_yaw, layout.foot_pitch)[axis]
    turn = {along: reach * (-1.0 if axis == 2 else sign)} if reach else {}
    return {layout.pivot + axis: sign} | turn, origin - float(pivot[1]) * (axis == 1)


def joint_form(biped: Biped, phase: Phase, quantity: str) -> tuple[Form, Form, float]:
    """Forms in the outputs and in the inputs that give a quantity of a joint, and the range that it may take."""
    layout, robot = layout_of(biped), biped.robot
    name, what = of_joint(quantity) or ("", "")
    joint = biped.names.index(name)
    local = int(biped.partner[joint]) if phase.side < 0 else joint
    sign = float(biped.sign[joint]) if phase.side < 0 else 1.0
    place = int(biped.index[joint])
    fast = 2.0 * float(robot.velocity_limit[place])
    span = {
        "angle": float(robot.position_high[place] - robot.position_low[place]),
        "velocity": fast,
        "acceleration": fast / biped.fall_time,
        "torque": 2.0 * float(robot.torque_limit[place]),
    }[what]
    if what == "torque":
        return {layout.torque + local: sign}, {}, span
    first = {"angle": layout.position, "velocity": layout.velocity, "acceleration": layout.acceleration}[what]
    return {}, {first + local: sign}, span
