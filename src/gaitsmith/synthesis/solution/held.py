"""Joints that are held: their angles and torques in a finished gait, and whether their limits hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from gaitsmith.splines.polynomial import chebyshev, chebyshev_fit, polynomial
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import Gait, Piece, root_of
from gaitsmith.synthesis.gaits.worst import Worst
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Condition, Motion, Phase, State
from gaitsmith.synthesis.motions.settings import Bounds
from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.program.bounds import joint_bounds
from gaitsmith.synthesis.solution.bound_check import BoundTable
from gaitsmith.synthesis.solution.certificate import merge

Array = npt.NDArray[np.float64]
_SAMPLES = 20  # Chebyshev nodes a piece


def of_all_joints(biped: Biped, motion: Motion) -> Motion:
    """A motion whose joint states have entries for all joints: those that are held are at home, at rest."""

    def whole(values: Array | None, others: Array) -> Array | None:
        if values is None:
            return None
        found = others.copy()
        found[biped.index] = values
        return found

    still = np.zeros(len(biped.home))
    found: list[Condition] = []
    for item in motion.conditions:
        if isinstance(item, State):
            states = whole(item.position, biped.home), whole(item.velocity, still), whole(item.acceleration, still)
            found.append(State(item.border, *states))
        else:
            found.append(item)
    return replace(motion, conditions=tuple(found))


def with_held(biped: Biped, motion: Motion, pieces: list[tuple[Piece, ...]]) -> list[tuple[Piece, ...]]:
    """All phases' pieces with rows for all joints: what the held ones bear follows from the motion of the others."""
    if not len(biped.held):
        return pieces
    finder = StateFinder(biped.robot, motion.slope)
    return [_with_held(biped, finder, *pair) for pair in zip(motion.phases, pieces, strict=True)]


def _with_held(biped: Biped, finder: StateFinder, phase: Phase, pieces: tuple[Piece, ...]) -> tuple[Piece, ...]:
    (nodes, to_series), found = chebyshev_fit(_SAMPLES), list[Piece]()
    for piece in pieces:
        joints = np.zeros((len(biped.home), piece.joints.shape[1]))
        joints[:, 0] = biped.home
        joints[biped.index] = piece.joints
        q, v, a = polynomial(joints, nodes, piece.duration)
        root = root_of(piece, nodes)
        wrench, none = chebyshev(piece.wrench, nodes), np.zeros(len(biped.home))
        loads = []
        for k in range(_SAMPLES):
            finder.find(phase.support, phase.stand, q[:, k], v[:, k], a[:, k], root[..., k])
            loads.append(finder.residual(none, wrench[:, k])[6 + biped.held])
        series = np.array(loads).T @ to_series
        torque = np.zeros((len(biped.home), max(series.shape[1], piece.torque.shape[1])))
        torque[biped.held, : series.shape[1]] = series
        torque[biped.index, : piece.torque.shape[1]] = piece.torque
        found.append(replace(piece, joints=joints, torque=torque))
    return tuple(found)


def held_margins(biped: Biped, bounds: Bounds, gait: Gait, count: int) -> dict[str, Worst]:
    """Worst values of the limits of the joints that are held, at ``count`` instants a phase."""
    layout, found = PointLayout(len(biped.home)), dict[str, Worst]()
    if not len(biped.held):
        return found
    table = BoundTable(layout, joint_bounds(biped.whole, bounds, 1.0, biped.held.tolist()))
    borders = gait.motion.borders
    for index, phase in enumerate(gait.motion.phases):
        times = np.linspace(borders[index], borders[index + 1], count)
        o, z = np.zeros((layout.outputs, count)), np.zeros((layout.inputs, count))
        q, v, _ = gait.joints(index, times)
        o[: layout.joints], z[: layout.joints] = gait.torques(index, times), q
        z[layout.velocity : layout.velocity + layout.joints] = v
        merge(found, phase, table.bounds, times, table.values(o, z, np.linspace(0.0, 1.0, count)))
    return found
