"""What geometry alone excludes, before anything is solved."""

from __future__ import annotations

import mujoco
import numpy as np

from gaitsmith.synthesis.motions.motion import At, Limit, Phase, about_vertical, turned
from gaitsmith.synthesis.motions.quantities import QUANTITIES, RATE, of_joint, unit_of
from gaitsmith.synthesis.program.quantities import quantity_form
from gaitsmith.synthesis.program.transcription import Transcription

_TOUCH = 1e-9  # m, m/s or a sine
_PLACED = ("ankle", "sole", "toe", "heel", "foot")


def out_of_reach(trans: Transcription) -> str:
    """Why geometry alone allows no motion, in words; empty where it might. Cheap to look at before solving.

    With the legs stretched out level the soles are at most two legs and the hips' share of the torso's yaw apart. A
    foot that lies flat has a place that no limit may exclude, and what a condition asks for has to lie within the
    limits that hold then.
    """
    biped, data = trans.biped, mujoco.MjData(trans.biped.model)
    mujoco.mj_kinematics(biped.model, data)
    chain = data.xanchor[biped.robot.legs[0].joint_indices + 1]
    leg = float(np.linalg.norm(np.diff(chain, axis=0), axis=1).sum())
    reach = 2.0 * leg + biped.width * float(np.sin(trans.settings.bounds.torso_yaw))
    motion, wanted = trans.motion, [item for item in trans.motion.conditions if isinstance(item, At)]
    for index, phase in enumerate(motion.phases):
        other = phase.straight.other
        apart = 0.0 if other is None else abs(other[0] - phase.foothold[0])
        if phase.contact == "flat" and apart > reach:
            return f"no solution: feet {apart:.3g} m apart in {phase.name}, the legs reach {reach:.3g} m at most"
        for limit in phase.limits:
            for border, neighbour in ((index, index - 1), (index + 1, index + 1)):
                rests = _resting(trans, neighbour, phase, limit.quantity)
                if rests is not None and not limit.low - _TOUCH <= rests <= limit.high + _TOUCH:
                    return _excluded(limit, rests, phase, "where the foot stands")
                for value in (
                    item.value for item in wanted if (item.border, item.quantity) == (border, limit.quantity)
                ):
                    if not limit.low - _TOUCH <= value <= limit.high + _TOUCH:
                        return _excluded(limit, value, phase, "that a condition asks for")
    for condition in wanted:
        phase = motion.phases[max(condition.border - 1, 0)]
        if condition.quantity in ("ankle_x", "sole_x"):
            apart = abs(condition.value - phase.foothold[0])
            if apart > reach:
                text = f"{condition.quantity} {apart:.3g} m from the support foot in {phase.name}"
                return f"no solution: {text}, the legs reach {reach:.3g} m at most"
    return ""


def _resting(trans: Transcription, neighbour: int, phase: Phase, quantity: str) -> float | None:
    """A quantity of the other foot as it lies flat in a neighbouring phase; None where it does not."""
    phases = trans.motion.phases
    if phase.double or not 0 <= neighbour < len(phases) or of_joint(quantity) is not None:
        return None
    if quantity == RATE:
        return None
    if QUANTITIES[quantity].part not in _PLACED:
        return None
    place = phases[neighbour].place(phase.other_foot)
    if phases[neighbour].contact != "flat" or place is None:
        return None
    layout, leg = trans.layout, trans.biped.leg(phase.other_foot)
    o = np.zeros(layout.outputs)
    x, y = turned((place[0] - phase.foothold[0], place[1] - phase.foothold[1]), -phase.heading)
    bend = phase.side * (phases[neighbour].facing(phase.other_foot) - phase.heading)
    origin = np.array([x, phase.side * y, phase.rise])
    ankle = about_vertical(bend) @ (-leg.sole_rotation.T @ leg.sole_position * (1.0, phase.side, 1.0))
    o[layout.pivot : layout.pivot + 3], o[layout.ankle : layout.ankle + 3] = origin, origin + ankle
    o[layout.foot_forward], o[layout.foot_yaw] = np.cos(bend), np.sin(bend)
    form, constant = quantity_form(trans.biped, phase, quantity)
    return constant + sum(factor * float(o[k]) for k, factor in form.items())


def _excluded(limit: Limit, value: float, phase: Phase, what: str) -> str:
    unit = unit_of(limit.quantity)
    bound = f"at least {limit.low:.3g}" if value < limit.low else f"at most {limit.high:.3g}"
    return f"no solution: {limit.quantity} {value:.3g} {unit}, {what}, is not {bound} {unit} as {phase.name} demands"
