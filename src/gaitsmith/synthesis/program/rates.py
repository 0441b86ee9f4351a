"""Bounds on torque rates: |dτ/dt| of every joint, imposed at the instants where a solution exceeds it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.program.bounds import Kind
from gaitsmith.synthesis.program.rows import Label
from gaitsmith.synthesis.program.transcription import Transcription

Array = npt.NDArray[np.float64]
UNIT = "N·m/s"


def is_rate(trans: Transcription, phase: int, bound: int) -> bool:
    """Whether an imposed bound is that of a rate: these count on from the phase's others, in local order of joints."""
    return bound >= len(trans.bounds[phase])


def rate_name(trans: Transcription, phase: int, local: int) -> str:
    """What the rate of a joint, in a phase's local order, is called."""
    biped = trans.biped
    joint = biped.partner[local] if trans.motion.phases[phase].side < 0 else local
    return f"{biped.names[int(joint)]} torque rate"


def rate_label(trans: Transcription, phase: int, bound: int, time: float, span: float) -> Label:
    """What the row of a rate's bound says."""
    name = rate_name(trans, phase, bound - len(trans.bounds[phase]))
    return Label(name, UNIT, phase, time, span, kind=Kind.TORQUE)


def steepest(trans: Transcription, phase: int) -> float:
    """The bound on torque rates in a phase, N·m/s."""
    return trans.motion.phases[phase].steepest(trans.settings.bounds.torque_rate)


def rate_form(trans: Transcription, phase: int, time: float) -> tuple[list[tuple[int, float]], Array]:
    """The rate at a time from the torques at the points of the section around it: these, and their weights; kept."""
    kept = trans.rates.get((phase, time))
    if kept is None:
        section = int(trans.instants(phase, np.array([time])).section[0])
        nodes = trans.nodes(phase, section)
        powers = np.arange(len(nodes))
        span = nodes[-1] - nodes[0]
        slope = powers[1:] * ((time - nodes[0]) / span) ** powers[:-1] / span
        weights = np.linalg.solve(np.vander((nodes - nodes[0]) / span, increasing=True).T, np.append(0.0, slope))
        kept = trans.rates[phase, time] = [(phase, round(float(t), 9)) for t in nodes], weights
    return kept
