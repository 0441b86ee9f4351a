"""What a file says of instants: conditions, states that go on from section to section, wrenches handed over, J."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from gaitsmith.splines.polynomial import chebyshev, polynomial
from gaitsmith.synthesis.gaits.full_state import FullState, StateFinder
from gaitsmith.synthesis.gaits.gait import Gait, Piece, follow
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import At, Condition, Same, State, Unloaded, about_vertical
from gaitsmith.synthesis.proof.definitions import allowed_of
from gaitsmith.synthesis.proof.measured import Errors, larger, measure
from gaitsmith.synthesis.proof.quantities import quantity

Array = npt.NDArray[np.float64]
SEAM = {"position_m": 1e-6, "angle_rad": 1e-5, "velocity": 1e-4, "acceleration": 1e-2}
_STATES = ("position", "velocity", "acceleration")
_ALLOWED = {"position": 1e-5, "velocity": 1e-4, "acceleration": 1e-2}  # rad, rad/s, rad/s²
_LOAD = 1e-5  # of the weight
_CLOCK = 1e-9  # s
_GAUSS, _FEW = 30, 8  # nodes a piece: exact for τᵀτ up to degree 29, and for a cubic u, which turns with its foot


def conditions(gait: Gait, biped: Biped, finder: StateFinder) -> list[tuple[str, float, float, float]]:
    """Of every number that the motion's conditions fix: what it is, wanted, found, allowed difference.

    A border is seen from the phase that ends there.
    """
    found: list[tuple[str, float, float, float]] = []
    borders = gait.motion.borders
    for item in gait.motion.conditions:
        index = max(item.border - 1, 0)
        time = np.array([borders[item.border]])
        if isinstance(item, At):
            numbers = measure(gait, biped, finder, index, time, Errors())
            value = float(quantity(numbers, biped, gait.motion.phases[index], item.quantity)[0])
            found.append((item.quantity, item.value, value, allowed_of(biped, item.quantity)))
        elif isinstance(item, Unloaded):
            wrench, phase = gait.wrenches(index, time)[:, 0], gait.motion.phases[index]
            most = float(np.abs(wrench[:6] if phase.support == "right" else wrench[6:]).max()) / biped.weight
            found.append((f"load of the {phase.other_foot} foot at border {item.border}", 0.0, most, _LOAD))
        else:
            found += _states(gait, biped, item, gait.joints(index, time))
    return found


def durations(gait: Gait) -> list[str]:
    """Phases that do not last as long as they may, in words."""
    found = []
    for phase in gait.motion.phases:
        low, high = phase.between or (phase.duration, phase.duration)
        if not low - _CLOCK <= phase.duration <= high + _CLOCK:
            found.append(f"{phase.name} lasts {phase.duration:.6g} s, not {low:.6g} to {high:.6g} s")
    total = gait.motion.total
    if total is not None and not abs(gait.duration - total) <= _CLOCK:
        found.append(f"all phases last {gait.duration:.6g} s, not {total:.6g} s")
    return found


def _states(
    gait: Gait, biped: Biped, item: Condition, here: tuple[Array, Array, Array]
) -> list[tuple[str, float, float, float]]:
    """Every joint of a condition on all of them."""
    wanted: dict[str, Array] = {}
    if isinstance(item, State):
        wanted = {name: values for name in _STATES if (values := getattr(item, name)) is not None}
    elif isinstance(item, Same):
        before = max(item.other - 1, 0)
        there = gait.joints(before, gait.motion.borders[[item.other]])[0][:, 0]
        wanted = {"position": biped.mirrored(there) if item.mirrored else there}
    found = []
    for name, values in wanted.items():
        real = here[_STATES.index(name)][:, 0]
        for joint, one, two in zip(gait.joint_names, values.tolist(), real.tolist(), strict=True):
            found.append((f"{joint} {name} at border {item.border}", one, two, _ALLOWED[name]))
    return found


def jumps(gait: Gait, biped: Biped) -> tuple[float, float]:
    """Largest jump of a joint torque (N·m), and of a contact wrench (of the weight), where sections meet.

    The seam of a cyclic gait is one of these places. A foot that meets or leaves the ground bears nothing there, and
    with the other one in the air the jump of its wrench would show.
    """
    phases = gait.motion.phases
    pieces = [(piece, phase.heading) for phase, group in zip(phases, gait.pieces, strict=True) for piece in group]
    ends, starts = ([_loads(*item, s) for item in pieces] for s in (1.0, 0.0))
    pairs = list(zip(ends[:-1], starts[1:], strict=True))
    if gait.motion.cyclic:
        image = follow(gait, gait, gait.motion.mirrored, biped.partner, biped.sign)
        pairs.append((ends[-1], _loads(image.pieces[0][0], image.motion.phases[0].heading, 0.0)))
    torque = max((float(np.abs(one[0] - two[0]).max()) for one, two in pairs), default=0.0)
    wrench = max((float(np.abs(one[1] - two[1]).max()) for one, two in pairs), default=0.0)
    first, last = phases[0], phases[-1]
    if not gait.motion.cyclic:  # what goes on elsewhere is handed over with the other foot free
        for phase, contact, values in ((first, "heel", starts[0][1]), (last, "toe", ends[-1][1])):
            if phase.contact == contact:
                other = values[:6] if phase.support == "right" else values[6:]
                wrench = larger(wrench, float(np.abs(other).max()))
    return torque, wrench / biped.weight


def _loads(piece: Piece, heading: float, s: float) -> tuple[Array, Array]:
    """Torques and wrenches of a piece at its start (0) or end (1); world axes."""
    wrench = chebyshev(piece.wrench, s).reshape(4, 3) @ about_vertical(heading).T
    return chebyshev(piece.torque, s), wrench.ravel()


def _state(gait: Gait, finder: StateFinder, index: int, time: float) -> FullState:
    """The robot in a phase at a time, s."""
    phase = gait.motion.phases[index]
    instant = np.array([time])
    q, v, a = (values[:, 0] for values in gait.joints(index, instant))
    return finder.find(phase.support, phase.stand, q, v, a, gait.roots(index, instant)[..., 0], phase.heading)


def seams(gait: Gait, biped: Biped, finder: StateFinder) -> dict[str, float]:
    """Jumps of the robot's state where phases meet and inside them, the cyclic seam included."""
    found, borders = dict.fromkeys(SEAM, 0.0), gait.motion.borders
    pairs = [tuple(_state(gait, finder, n, borders[k + 1]) for n in (k, k + 1)) for k in range(len(borders) - 2)]
    if gait.motion.cyclic:
        image = follow(gait, gait, gait.motion.mirrored, biped.partner, biped.sign)
        end = _state(gait, finder, len(borders) - 2, borders[-1])
        pairs.append((end, _state(image, finder, 0, image.pieces[0][0].start)))
    for end, begin in pairs:
        away = float(np.minimum(1.0, abs(float(end.position[3:7] @ begin.position[3:7]))))
        angle = larger(np.abs(end.position[7:] - begin.position[7:]).max(), 2.0 * np.arccos(away))
        _add(found, "position_m", np.abs(end.position[:3] - begin.position[:3]).max())
        _add(found, "angle_rad", angle)
        _add(found, "velocity", np.abs(end.velocity - begin.velocity).max())
        _add(found, "acceleration", np.abs(end.acceleration - begin.acceleration).max())
    for group in gait.pieces:
        for one, two in pairwise(group):
            left, right = _edge(one, -1), _edge(two, 0)
            for name, before, after in zip(("angle_rad", "velocity", "acceleration"), left, right, strict=True):
                _add(found, name, np.abs(before - after).max())
    return found


def _edge(piece: Piece, which: int) -> list[Array]:
    """Angles, velocities and accelerations of joints, and of a support sole that moves, at a piece's start or end."""
    tables, s = (piece.joints, piece.root), np.array([1.0 if which < 0 else 0.0])
    return list(np.concatenate([polynomial(table, s, piece.duration)[:, :, 0] for table in tables], axis=1))


def _add(found: dict[str, float], name: str, value: float) -> None:
    found[name] = larger(found[name], float(value))


def objective(gait: Gait, biped: Biped, finder: StateFinder, weight: float, joints: Array) -> float:
    """(16): ∫ τᵀWτ + ρ uᵀu dt of the file's own curves; u is about the point that the foot turns about.

    Args:
        gait: the gait.
        biped: the robot with all its joints.
        finder: of its states.
        weight: ρ.
        joints: (n,) W, weights of the joints' torques.

    Joints outside the legs that are held count as well: the file's torques are all there is.
    """
    nodes, shares = np.polynomial.legendre.leggauss(_GAUSS)
    few, parts = np.polynomial.legendre.leggauss(_FEW)
    total = 0.0
    for index, group in enumerate(gait.pieces):
        loads = np.zeros((len(group), _FEW))
        if gait.motion.phases[index].double:
            times = np.concatenate([piece.start + 0.5 * (few + 1.0) * piece.duration for piece in group])
            numbers = measure(gait, biped, finder, index, times, Errors())
            loads = np.sum(np.concatenate([numbers.push, numbers.turn]) ** 2, axis=0).reshape(loads.shape)
        for piece, load in zip(group, loads, strict=True):
            effort = shares @ (joints @ chebyshev(piece.torque, 0.5 * (nodes + 1.0)) ** 2)
            total += 0.5 * piece.duration * float(effort + weight * parts @ load)
    return total
