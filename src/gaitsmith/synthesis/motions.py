"""The paper's motions as data: cyclic, start, stop, kick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitsmith.synthesis.biped import Biped
from gaitsmith.synthesis.motion import At, Motion, Phase


@dataclass(frozen=True)
class StepParameters:
    """One step of a walk.

    Attributes:
        length: L_step, distance from one foothold to the next, m.
        period: of a step, s.
        height: H_step, ankle above its height on the ground at mid-swing, m.
        double_support: share of the period.
        split: shares of the double support in which the front foot turns about its heel, both are flat, and the rear
            foot turns about its toe.
        toe_off: q_b, pitch of the rear foot as it leaves the ground, rad.
        heel_strike: q_f, pitch of the front foot as it meets the ground, rad, toe up.
    """

    length: float
    period: float
    height: float = 0.04
    double_support: float = 0.30
    split: tuple[float, float, float] = (0.30, 0.40, 0.30)
    toe_off: float = 0.20
    heel_strike: float = 0.15


def step_phases(
    biped: Biped, step: StepParameters, support: str, foothold: tuple[float, float], landing: tuple[float, float]
) -> list[Phase]:
    """Five phases of a step: swing up, swing down, heel, flat, toe."""
    swing = "left" if support == "right" else "right"
    single, double = step.period * (1.0 - step.double_support), step.period * step.double_support
    a, b, c = (double * share for share in step.split)
    return [
        Phase("swing up", single / 2, support, "air", foothold, sections=1),  # type: ignore[arg-type]
        Phase("swing down", single / 2, support, "air", foothold, sections=1),  # type: ignore[arg-type]
        Phase("heel", a, support, "heel", foothold, landing, sections=2),  # type: ignore[arg-type]
        Phase("flat", b, support, "flat", foothold, landing, sections=2),  # type: ignore[arg-type]
        Phase("toe", c, swing, "toe", landing, foothold, sections=2),  # type: ignore[arg-type]
    ]


def cyclic(biped: Biped, step: StepParameters) -> Motion:
    """One step of the cyclic walk, the right foot as first support; six-point boundary constraints (1)-(6)."""
    half = biped.width / 2.0
    phases = step_phases(biped, step, "right", (0.0, -half), (step.length, half))
    conditions = (
        At(1, "ankle_z", biped.ankle_height + step.height),
        At(1, "ankle_vz", 0.0),
        At(2, "foot_pitch", -float(np.sin(step.heel_strike))),
        At(5, "foot_pitch", float(np.sin(step.toe_off))),
    )
    return Motion("cyclic", tuple(phases), conditions, cyclic=True)
