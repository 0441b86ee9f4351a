"""Torque rates of the curves as they will be stored: where they exceed their bound, and what to impose there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gaitsmith.splines.polynomial import chebyshev_fit, chebyshev_slopes
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.worst import Worst
from gaitsmith.synthesis.point.functions import PointFunctions
from gaitsmith.synthesis.program.bounds import Kind, PhaseBound
from gaitsmith.synthesis.program.program import ImposedBound
from gaitsmith.synthesis.program.rates import UNIT, rate_name, steepest
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.bound_check import BoundCheck, places_of
from gaitsmith.synthesis.solution.certificate import merge
from gaitsmith.synthesis.solution.curves_from_solution import inputs_at
from gaitsmith.synthesis.solution.passive import balanced

Array = npt.NDArray[np.float64]
_SAMPLES = 12  # Chebyshev nodes a piece
_FINE = 16  # instants a piece at which a rate is looked at
_INSIDE = 1e-3  # of a piece: how far its first and last such instants are said to lie inside
_BETWEEN = 2e-3  # of the bound: what lies between these instants
_MARGIN = 0.01  # of the bound: how far below it rates are imposed
_TIGHTEST = 0.4  # of a span
_NEAR, _SAME = 0.15, 0.03  # of a section: instants that say much the same, and as good as the same
_ALSO, _BESIDE = 0.9, 0.12  # of the bound, of a section: rates imposed beside the worst, and how far from others


@dataclass(frozen=True, eq=False)
class Rates:
    """Torque rates of one phase: times (N,), s, and rates (n, N), N·m/s, joints in local order."""

    times: Array
    values: Array


def torque_rates_of(trans: Transcription, functions: PointFunctions, x: Array, checks: list[BoundCheck]) -> list[Rates]:
    """The derivatives of the torques' series, phase by phase."""
    n, found = trans.biped.joints, []
    nodes, to_series = chebyshev_fit(_SAMPLES)
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, _FINE))
    said = np.clip(share, _INSIDE, 1.0 - _INSIDE)  # at a knot a rate jumps: its instant must tell on which side
    slopes = chebyshev_slopes(to_series, 2.0 * share - 1.0)
    for phase, item in enumerate(checks):
        z = balanced(trans, functions, phase, inputs_at(trans, x, phase, item.pieces, nodes))
        o = functions.evaluate(
            z, np.tile(trans.pivots[phase][:, None], (1, z.shape[1])), trans.motion.phases[phase].side
        )
        starts, spans = (np.array([piece[k] for piece in item.pieces])[:, None] for k in range(2))
        rates = (o[:n].reshape(n, len(spans), -1) @ slopes) * (2.0 / spans)
        found.append(Rates((starts + spans * said).ravel(), rates.reshape(n, -1)))
    return found


def largest_rate(rates: list[Rates]) -> float:
    """Of any joint, N·m/s."""
    return float(max(np.abs(item.values).max() for item in rates))


def too_fast(trans: Transcription, rates: list[Rates]) -> bool:
    """Whether any rate exceeds its bound; quartics jump, so that they have none."""
    return trans.settings.order > 4 and max(_ratios(trans, rates)) > 1.0 - _BETWEEN


def _ratios(trans: Transcription, rates: list[Rates]) -> list[float]:
    """Of every phase, the largest rate as a share of its bound."""
    return [float(np.abs(item.values).max()) / steepest(trans, phase) for phase, item in enumerate(rates)]


def asked_too_fast(trans: Transcription, rates: list[Rates]) -> bool:
    """Whether a rate exceeds a phase's own bound, which is never relaxed."""
    ratios = zip(trans.motion.phases, _ratios(trans, rates), strict=True)
    return any(np.isfinite(phase.steepest(np.inf)) and ratio > 1.0 - _BETWEEN for phase, ratio in ratios)


def fastest(trans: Transcription, rates: list[Rates]) -> str:
    """The largest rate beside its bound, in words."""
    phase = int(np.argmax(_ratios(trans, rates)))
    values = rates[phase].values
    local = int(np.argmax(np.abs(values).max(axis=1)))
    pair = f"{np.abs(values[local]).max():.4g} of {steepest(trans, phase):.4g} {UNIT}"
    return f"{rate_name(trans, phase, local)} {pair} in {trans.motion.phases[phase].name}"


def with_fast(
    trans: Transcription, rates: list[Rates], imposed: list[ImposedBound], settled: bool = True
) -> list[ImposedBound]:
    """The imposed bounds, with each joint's largest excess in every section added or tightened.

    ``settled``: whether they hold to the solver's tolerance; after a rough solve none is tightened.
    """
    found, places = list(imposed), places_of(imposed)
    for phase, item in enumerate(rates):
        most = (1.0 - _BETWEEN) * steepest(trans, phase)
        sections = trans.instants(phase, item.times).section
        first = trans.first_section[phase]
        for section in range(first, first + trans.motion.phases[phase].sections):
            inside = np.flatnonzero(sections == section)
            ratios = np.abs(item.values[:, inside]) / most
            for local in np.flatnonzero(ratios.max(axis=1) > 1.0).tolist():
                bound = len(trans.bounds[phase]) + local
                here, count = places[phase, bound], len(found)
                at = np.array([found[index].time for index in here])
                same = trans.instants(phase, at).section == section if here else ()
                near = [index for index, inside_too in zip(here, same, strict=True) if inside_too]
                span = float(np.diff(trans.spline.knots)[section])
                _impose(found, near, phase, bound, item.times[inside], ratios[local], span, settled)
                here += range(count, len(found))
    return found


def _impose(
    found: list[ImposedBound],
    near: list[int],
    phase: int,
    bound: int,
    times: Array,
    ratios: Array,
    span: float,
    settled: bool,
) -> None:
    """Add or tighten the worst instant of a section, and add those beside it to which the worst may move."""
    for k in np.argsort(-ratios).tolist():
        if ratios[k] < _ALSO:
            break
        time, worst = float(times[k]), k == int(np.argmax(ratios))
        apart, index = min(((abs(found[index].time - time) / span, index) for index in near), default=(1.0, -1))
        tighten = found[index].tighten if apart < _NEAR else 0.5 * _MARGIN
        if apart > (_SAME if worst else _BESIDE):
            near.append(len(found))
            found.append(ImposedBound(phase, bound, time, tighten))
        elif settled and worst:
            more = 0.5 * (float(ratios[k]) - 1.0) + _MARGIN
            found[index] = ImposedBound(phase, bound, found[index].time, min(tighten + more, _TIGHTEST))


def rate_margins(gait: Gait, most: float, moving: Sequence[str], count: int) -> dict[str, Worst]:
    """Worst torque rates of the joints that move, at ``count`` instants a phase of a finished gait.

    ``most``: where a phase has no bound of its own.
    """
    found: dict[str, Worst] = {}
    places = [gait.joint_names.index(name) for name in moving]
    names = [f"{name} torque rate" for name in moving]
    borders = gait.motion.borders
    for index, phase in enumerate(gait.motion.phases):
        times, here = np.linspace(borders[index], borders[index + 1], count), phase.steepest(most)
        bounds = [PhaseBound(Kind.TORQUE, name, UNIT, {}, {}, -here, here, 2.0 * here) for name in names]
        merge(found, phase, bounds, times, gait.torque_rates(index, times)[places])
    return found
