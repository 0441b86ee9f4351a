"""Figures of a gait for reports: peak torques, ZMP margin, speed."""

from __future__ import annotations

from typing import Any

import numpy as np

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot
from gaitsmith.synthesis.files.gait_file import gait_document, gait_of
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.proof.verify import Verdict, verify
from gaitsmith.synthesis.requests.request import Answer

_SAMPLES = 200  # a phase
_INSTANTS = 40  # a section
_WHOLE = ("walk", "stairs", "turn")  # motions that are put together from several


def peak_torques(gait: Gait) -> dict[str, float]:
    """Largest |torque| of every joint, N·m."""
    peaks = np.zeros(len(gait.joint_names))
    borders = gait.motion.borders
    for phase in range(len(gait.motion.phases)):
        times = np.linspace(borders[phase], borders[phase + 1], _SAMPLES)
        peaks = np.maximum(peaks, np.abs(gait.torques(phase, times)).max(axis=1))
    return dict(zip(gait.joint_names, peaks.tolist(), strict=True))


def largest_torque_rate(gait: Gait) -> float:
    """Largest |dτ/dt| of any joint, N·m/s, from the derivatives of the torques' series."""
    share, largest = np.linspace(-1.0, 1.0, _INSTANTS), 0.0
    for piece in (piece for group in gait.pieces for piece in group):
        rates = np.polynomial.chebyshev.chebval(share, piece.torque_slope.T)
        largest = max(largest, float(np.abs(rates).max()))
    return largest


def plan_document(found: Answer, kind: str, biped: Biped, file: str | None) -> dict[str, Any]:
    """What ``gaitsmith plan --json`` prints."""
    main, results = found.main, found.results.values()
    times = {name: sum(item.times[name] for item in results) for name in main.times}
    gait = found.gait
    worst = [item.as_dict() for item in main.worst]
    if gait is not None:
        worst = list(gait.certificate.get("worst", worst))
    verdict, problems = (None, list[str]()) if gait is None else _judged(gait, biped.robot)
    return {
        "status": main.status,
        "reason": main.reason,
        "verified": gait is not None and not problems,
        "undecided": main.status not in ("solved", "not solved"),
        "motion": kind,
        "step": None if gait is None else _step(gait),
        "without_solution": list(found.periods),
        "objective": _objective(found, kind),
        "iterations": sum(item.iterations for item in results),
        "refinements": sum(item.rounds for item in results),
        "time_s": times,
        "variables": sum(item.variables for item in results) if kind in _WHOLE else main.variables,
        "constraints": sum(item.constraints for item in results) if kind in _WHOLE else main.constraints,
        "fallbacks": sum(item.fallbacks for item in results),
        "duration": None if gait is None else gait.duration,
        "free_durations": {} if gait is None else _chosen(gait),
        "max_torque": None if gait is None else peak_torques(gait),
        "zmp_margin_mm": None if verdict is None else verdict.zmp_margin,
        "torque_jump": None if verdict is None else verdict.torque_jump,
        "torque_rate_max": None if gait is None else largest_torque_rate(gait),
        "torque_rate_bound": None if gait is None else gait.bounds["torque_rate"],
        "warnings": _relaxed(found) + [f"verify rejects this gait: {problem}" for problem in problems],
        "worst": worst,
        "solves": {
            name: {"status": item.status, "iterations": item.iterations, "objective": item.objective, **item.times}
            for name, item in found.results.items()
        },
        "symmetric": biped.symmetric,
        "asymmetry": biped.asymmetry,
        "held": [biped.robot.joint_names[joint] for joint in biped.held],
        "file": file,
    }


def _relaxed(found: Answer) -> list[str]:
    """Default bounds that left no gait, in words."""
    return [
        f"torque rates of {name} are bounded by {item.gait.bounds['torque_rate']:.4g} N·m/s: "
        f"the default, {item.default_rate:.4g} N·m/s, left no gait"
        for name, item in found.results.items()
        if item.default_rate is not None and item.gait is not None
    ]


def rejections(gait: Gait, robot: Robot) -> list[str]:
    """Why ``gaitsmith verify`` would not accept a gait's file, in words."""
    return _judged(gait, robot)[1]


def _judged(gait: Gait, robot: Robot) -> tuple[Verdict | None, list[str]]:
    """What :func:`verify` says of a gait's file, None if it cannot be read; and why it would not be accepted."""
    try:
        verdict = verify(gait_of(gait_document(gait)), robot)
    except BadInput as error:
        return None, [str(error)]
    return verdict, verdict.problems


def _chosen(gait: Gait) -> dict[str, float]:
    """Durations of the phases that left them free, s."""
    return {phase.name: phase.duration for phase in gait.motion.phases if phase.between is not None}


def _step(gait: Gait) -> dict[str, float]:
    """Length and period of a walk's step, m and s; of another motion nothing."""
    return {
        name: float(gait.motion.parameters[name]) for name in ("length", "period") if name in gait.motion.parameters
    }


def _objective(found: Answer, kind: str) -> float | None:
    """J of eq. (16) over the whole motion, every cycle of a walk counted; None where nothing was solved."""
    if kind in _WHOLE and found.gait is not None:
        return float(found.gait.certificate["objective"])
    return found.main.objective if np.isfinite(found.main.objective) else None
