"""What a plan leaves to a neighbour that starts from it: the bounds that lie near, at the same shares of the phases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.program.program import ImposedBound, Program
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
