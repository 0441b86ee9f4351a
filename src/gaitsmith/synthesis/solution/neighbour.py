"""What a plan leaves to another that starts from it.

To a neighbour of the same phases and sections its unknowns, and the bounds that lie near, at the same shares of the
phases; to any other its curves, where phases have the same name.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.motions.motion import Motion, Phase
from gaitsmith.synthesis.program.program import ImposedBound, Program
from gaitsmith.synthesis.program.transcription import WRENCH_DEGREE, Transcription
from gaitsmith.synthesis.solution.ipopt import Solution

Array = npt.NDArray[np.float64]
_NEAR = 0.3  # of a bound's range: rows that a neighbour keeps


def near_bounds(
    program: Program, imposed: list[ImposedBound], found: Solution, o: Array
) -> tuple[list[ImposedBound], Solution]:
    """The imposed bounds that lie near their bounds, and the solution's multipliers without those of the others.

    A neighbour starts with these, and with the instants at which it may meet its bounds; the dense grid sees
    to the rest.
    """
    first = program.rows - len(imposed)
    rows = program.constraint(found.x, o)
    room = np.minimum(program.high - rows, rows - program.low)[first:]
    keep = np.flatnonzero(room < _NEAR)
    multipliers = np.concatenate([found.multipliers[:first], found.multipliers[first:][keep]])
    return [imposed[k] for k in keep], replace(found, multipliers=multipliers)


def rescaled(imposed: list[ImposedBound], old: Array, new: Array) -> list[ImposedBound]:
    """Imposed bounds of one motion at the same shares of the phases of another."""
    found = []
    for item in imposed:
        share = (item.time - old[item.phase]) / (old[item.phase + 1] - old[item.phase])
        time = new[item.phase] + share * (new[item.phase + 1] - new[item.phase])
        found.append(ImposedBound(item.phase, item.bound, float(time), item.tighten))
    return found


def alike(one: Motion, two: Motion) -> bool:
    """Whether the unknowns of both motions mean the same."""
    kinds = (
        [(item.name, item.support, item.contact, item.sections) for item in motion.phases] for motion in (one, two)
    )
    return next(kinds) == next(kinds)


def start_from(trans: Transcription, usual: Array, gait: Gait, unknowns: Array) -> Array:
    """Unknowns (size,) to start from: a gait's curves in phases that it has too, mirrored where the other foot stands.

    They begin and end gradually, over one length of the gait, where a motion has phases that the gait does not have.

    Args:
        trans: of the motion that is to be planned.
        usual: unknowns of standing still.
        gait: planned for the same robot.
        unknowns: the gait's own.
    """
    x, biped, borders = usual.copy(), trans.biped, trans.motion.borders
    times, old, n = trans.spline.places, gait.motion, trans.biped.joints
    control = x[: biped.channels * trans.spline.size].reshape(biped.channels, -1)
    partners = [_partner(old, item, biped.symmetric) for item in trans.motion.phases]
    away = np.full(len(times), np.inf)
    for k, partner in enumerate(partners):
        if partner is None:
            away = np.minimum(away, np.maximum(0.0, np.maximum(borders[k] - times, times - borders[k + 1])))
    share = np.minimum(away / gait.duration, 1.0)
    share = share**2 * (3.0 - 2.0 * share)
    inside = np.clip(np.searchsorted(borders, times, side="right") - 1, 0, len(partners) - 1)
    flat = [k for k, item in enumerate(old.phases) if item.double]
    size = 6 * (WRENCH_DEGREE + 1)
    loads = unknowns[len(unknowns) - size * len(flat) :].reshape(-1, 6, WRENCH_DEGREE + 1)
    for k, partner in enumerate(partners):
        if partner is None:
            continue
        item, source, here = trans.motion.phases[k], old.phases[partner], np.flatnonzero(inside == k)
        at = old.borders[partner] + (times[here] - borders[k]) * (source.duration / item.duration)
        curves = gait.joints(partner, at)[0][biped.index]
        curves = curves if item.support == source.support else biped.mirrored(curves.T).T
        control[:n, here] += share[here] * (curves - control[:n, here])
        if item.double and not (old.flies or old.tips):  # else other unknowns are behind these
            x[trans.wrench_columns(k)] = loads[flat.index(partner)]
    return x


def _partner(motion: Motion, phase: Phase, mirrored: bool) -> int | None:
    """Index of a phase of the same name, on the same foot if there is one; with ``mirrored`` also on the other."""
    named = [k for k, item in enumerate(motion.phases) if (item.name, item.contact) == (phase.name, phase.contact)]
    own = [k for k in named if motion.phases[k].support == phase.support]
    return next(iter(own or (named if mirrored else [])), None)
