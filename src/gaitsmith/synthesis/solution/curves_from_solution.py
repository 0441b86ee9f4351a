"""The curves of a solution, with the dependent joints of double support solved from the closed chain.

The program holds the closure at the knots only. Here the support leg and the other foot's pitch keep their splines,
and the other leg follows from them at finer knots; quintic Hermite pieces between these keep the error far below
what the knots alone give. Torques and the support wrench follow from the dynamics.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from gaitsmith.splines.polynomial import bernstein_to_power, chebyshev, chebyshev_fit, hermite, polynomial, power_basis
from gaitsmith.synthesis.gaits.gait import Piece
from gaitsmith.synthesis.point.functions import PointFunctions
from gaitsmith.synthesis.program.boundary import other_place
from gaitsmith.synthesis.program.transcription import WRENCH_DEGREE, Transcription
from gaitsmith.synthesis.solution.passive import LocalPiece, balanced

Array = npt.NDArray[np.float64]
PARTS = 4  # pieces a section of double support is cut into
_NEWTON = 8
_CLOSED, _FAR = 1e-8, 0.2  # m or rad left of a gap; largest correction of a joint, rad
_SAMPLES = 20  # Chebyshev nodes a piece
_TRIFLE = 1e-11  # of the largest coefficient; a ZMP that stays on an edge is proved there to 1e-9 of the sole
_MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


def _solve_closure(trans: Transcription, functions: PointFunctions, phase: int, z: Array) -> Array:
    """Inputs (inputs, N) of a double-support phase with the other leg's joints solved from the closure."""
    layout, n = trans.layout, trans.layout.coordinates
    item = trans.motion.phases[phase]
    cos, sin = np.cos(item.bend), np.sin(item.bend)
    pivots = np.tile(trans.pivots[phase][:, None], (1, z.shape[1]))
    goal = np.array([*other_place(item, trans.pivots[phase]), item.rise])
    leg = trans.biped.leg_joints("left")
    o = functions.evaluate(z, pivots, item.side)
    flat = item.contact == "flat"
    pitch = np.zeros(z.shape[1]) if flat else o[layout.foot_pitch]
    rate, pull = (
        np.zeros(z.shape[1]) if flat else cos * o[first + 1] - sin * o[first]
        for first in (layout.foot_omega, layout.foot_alpha)
    )
    places = [layout.pivot, layout.pivot + 1, layout.pivot + 2, layout.foot_roll, layout.foot_pitch, layout.foot_yaw]
    target = np.vstack([np.tile(goal[:, None], (1, z.shape[1])), 0 * pitch, pitch, 0 * pitch])
    turn = np.eye(layout.outputs)[places]  # the last row: the sole's forward axis across where it is to point
    turn[5, [layout.foot_yaw, layout.foot_forward]] = cos, -sin
    given, z = z, z.copy()
    speeds = list(range(layout.pivot_velocity, layout.pivot_velocity + 6))
    pulls = list(range(layout.pivot_acceleration, layout.pivot_acceleration + 6))
    zero = np.zeros((3, z.shape[1]))
    wanted_speed, wanted_pull = (np.vstack([zero, -sin * about, cos * about, zero[0]]) for about in (rate, pull))
    for _ in range(_NEWTON):
        o, J = functions.differentiate(z, pivots, item.side)
        gap = target - turn @ o
        step = np.linalg.solve(turn @ J[:, :, leg], gap.T[:, :, None])[:, :, 0]
        z[leg] += step.T
        if np.abs(gap).max() < 1e-13:
            break
    # Near a straight leg the chain may have no solution: the splines are kept there, and the gap shows in the check.
    lost = ~(np.abs(gap).max(axis=0) < _CLOSED) | (np.abs(z[leg] - given[leg]).max(axis=0) > _FAR)
    z[:, lost] = given[:, lost]
    usable = ~lost
    for wanted, rows, first in ((wanted_speed, speeds, n), (wanted_pull, pulls, 2 * n)):
        o, J = functions.differentiate(z, pivots, item.side)
        columns = [first + int(k) for k in leg]
        if not usable.any():
            break
        step = np.linalg.solve(J[usable][:, rows][:, :, columns], (wanted - o[rows]).T[usable][:, :, None])[:, :, 0]
        z[np.array(columns)[:, None], np.flatnonzero(usable)] += step.T
    return z


def _solve_lines(trans: Transcription, functions: PointFunctions, phase: int, z: Array) -> Array:
    """The same for line soles: the least changes of all coordinates that leave no moment about the support's line."""
    layout, c = trans.layout, trans.layout.coordinates
    item = trans.motion.phases[phase]
    assert item.other is not None
    goal = np.zeros((6, 1))
    goal[:3, 0] = item.other[0] - item.foothold[0], item.side * (item.other[1] - item.foothold[1]), item.rise
    pivots, z, lean = np.zeros((3, z.shape[1])), z.copy(), layout.joints + 1
    places = [*range(layout.pivot, layout.pivot + 3), layout.lean_gap, layout.foot_pitch, layout.foot_yaw]
    for first, rows, rounds in (
        (layout.position, places, _NEWTON),
        (layout.velocity, range(layout.pivot_velocity, layout.pivot_velocity + 6), 1),
        (layout.acceleration, [*range(layout.pivot_acceleration, layout.pivot_acceleration + 6), layout.moment], 1),
    ):
        for _ in range(rounds):
            o, J = functions.differentiate(z, pivots, item.side)
            gap, slope = o[list(rows)], J[:, list(rows), first : first + c]
            if first == layout.position:
                gap = gap - goal
            else:
                gap[3] -= z[first + lean]
                slope[:, 3, lean] -= 1.0
            z[first : first + c] -= (np.linalg.pinv(slope) @ gap.T[:, :, None])[:, :, 0].T
    return z


def _knots(trans: Transcription, phase: int) -> Array:
    """Borders of a phase's pieces, s."""
    first = trans.first_section[phase]
    sections = trans.motion.phases[phase].sections
    knots = trans.spline.knots[first : first + sections + 1]
    if not trans.motion.phases[phase].double or trans.settings.order < 5:
        return np.array(knots)
    fine = [a + (b - a) * k / PARTS for a, b in pairwise(knots) for k in range(PARTS)]
    return np.array([*fine, knots[-1]])


def _states(trans: Transcription, x: Array, phase: int, knots: Array) -> Array:
    """Local inputs (inputs, N) of a phase at its knots."""
    if phase not in trans.maps:
        trans.maps[phase] = trans.input_map(trans.instants(phase, knots))
    return np.array((trans.maps[phase] @ x).reshape(len(knots), trans.layout.inputs).T)


def phase_pieces(trans: Transcription, functions: PointFunctions, x: Array, phase: int) -> list[LocalPiece]:
    """Start, duration and local coefficients (c, degree + 1) of a phase's pieces."""
    n = trans.layout.coordinates
    knots = _knots(trans, phase)
    z = _states(trans, x, phase, knots)
    item = trans.motion.phases[phase]
    if item.double and trans.settings.order >= 5 and len(knots) > 2:
        solve = _solve_lines if trans.layout.leans else _solve_closure
        z[:, 1:-1] = solve(trans, functions, phase, z[:, 1:-1])
    if trans.settings.order >= 5:
        states = z[: 3 * n].reshape(3, n, len(knots))
        return [
            (float(a), float(b - a), hermite(float(b - a), states[:, :, k], states[:, :, k + 1]))
            for k, (a, b) in enumerate(pairwise(knots))
        ]
    basis, found = bernstein_to_power(trans.settings.order), []
    for k, (a, b) in enumerate(pairwise(knots)):
        section = trans.first_section[phase] + k
        control = np.array([x[trans.joint_columns(j, section)] for j in range(n)])
        joints = control @ (basis @ trans.spline.sections[section]).T
        found.append((float(a), float(b - a), trans.biped.mirrored(joints.T).T if item.side < 0 else joints))
    return found


def _wrench_at(trans: Transcription, x: Array, phase: int, times: Array) -> Array:
    """U (6, N) of a phase, N and N·m, about the pivot, local axes."""
    item = trans.motion.phases[phase]
    if not item.double:
        return np.zeros((6, len(times)))
    s = np.clip((times - trans.motion.borders[phase]) / item.duration, 0.0, 1.0)
    coefficients = trans.biped.weight * x[trans.wrench_columns(phase)] @ bernstein_to_power(WRENCH_DEGREE).T
    return np.asarray(coefficients @ power_basis(WRENCH_DEGREE, s))


def local_inputs(trans: Transcription, x: Array, phase: int, pieces: list[LocalPiece], times: Array) -> Array:
    """Inputs (inputs, N) of a phase from its pieces."""
    n = trans.layout.coordinates
    z = np.zeros((trans.layout.inputs, len(times)))
    starts = np.array([start for start, _, _ in pieces])
    index = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, len(pieces) - 1)
    for k, (start, span, joints) in enumerate(pieces):
        mask = np.flatnonzero(index == k)
        if len(mask) == 0:
            continue
        s = np.clip((times[mask] - start) / span, 0.0, 1.0)
        z[: 3 * n, mask] = polynomial(joints, s, span).reshape(3 * n, -1)
    z[3 * n :] = _wrench_at(trans, x, phase, times)
    return z


def inputs_at(trans: Transcription, x: Array, phase: int, pieces: list[LocalPiece], nodes: Array) -> Array:
    """Inputs (inputs, P * N) of a phase at normalised times (N,) of each of its pieces."""
    starts, spans = (np.array([piece[k] for piece in pieces])[:, None] for k in range(2))
    joints = np.array([piece[2] for piece in pieces])  # (P, c, degree + 1)
    curves = [joints @ power_basis(joints.shape[2] - 1, nodes, k) / spans[:, :, None] ** k for k in range(3)]
    states = np.concatenate(curves, axis=1).transpose(1, 0, 2).reshape(trans.layout.wrench, -1)
    return np.vstack([states, _wrench_at(trans, x, phase, (starts + spans * nodes).ravel())])


def finished_pieces(
    trans: Transcription, functions: PointFunctions, x: Array, phase: int, pieces: list[LocalPiece]
) -> tuple[Piece, ...]:
    """A phase's pieces in the robot's own order and world axes, with torques and both wrenches."""
    layout, n = trans.layout, trans.biped.joints
    item = trans.motion.phases[phase]
    nodes, to_series = chebyshev_fit(_SAMPLES)
    z = balanced(trans, functions, phase, inputs_at(trans, x, phase, pieces, nodes))
    o = functions.evaluate(z, np.tile(trans.pivots[phase][:, None], (1, z.shape[1])), item.side)
    torque, support = o[layout.torque : layout.torque + n], o[layout.force : layout.force + 6]
    u = z[layout.wrench :].copy()
    x, y = trans.pivots[phase][:2]
    # From the pivot to the sole frame's origin: r = pivot minus origin, in local axes.
    along = np.vstack([o[layout.foot_forward], o[layout.foot_yaw], -o[layout.foot_pitch]])
    across = np.full(z.shape[1], np.cos(item.bend))
    r = x * along + y * np.vstack([-o[layout.foot_yaw], across, o[layout.foot_roll]])
    u[3:] += np.cross(r.T, u[:3].T).T
    if item.tips:  # about the sole frame's origin, which moves
        place = o[layout.own : layout.own + 3]
        support = np.vstack([support[:3], support[3:] - np.cross(place.T, support[:3].T).T])
    if item.flies:  # to what the equations of motion leave
        support = 0.0 * support
    joints = [coefficients[:n, : trans.settings.order + 1] for _, _, coefficients in pieces]
    own = slice(layout.pose, layout.pose + 6) if item.flies else slice(n, n + layout.leans // 2)
    signs = np.ones(6) if item.side > 0 else _MIRROR
    roots = [signs[6 - (own.stop - own.start) :, None] * coefficients[own] for _, _, coefficients in pieces]
    roots = [root if len(root) else np.zeros((0, 1)) for root in roots]
    if item.tips:
        roots = [_about_toe(c[layout.pose], trans.biped.sole(item.support).ends[1][0]) for _, _, c in pieces]
    if item.side < 0:
        torque = trans.biped.mirrored(torque.T).T
        support, u = support * _MIRROR[:, None], u * _MIRROR[:, None]
        joints = [trans.biped.mirrored(c.T).T for c in joints]
    wrench = np.vstack([u, support] if item.support == "right" else [support, u])
    parts = np.split(np.vstack([torque, wrench]), len(pieces), axis=1)
    series = [_trimmed(part[:n] @ to_series) for part in parts], [_trimmed(part[n:] @ to_series) for part in parts]
    every = zip(pieces, joints, *series, roots, strict=True)
    return tuple(Piece(start, span, *each) for (start, span, _), *each in every)


def _about_toe(pitch: Array, reach: float) -> Array:
    """(6, m) pose of a sole that turns about its toe's edge by a polynomial, as polynomials.

    Args:
        pitch: its coefficients, rad.
        reach: of the toe from the sole frame, m.
    """
    s, to_series = chebyshev_fit(_SAMPLES)
    angle = np.polynomial.polynomial.polyval(s, pitch)
    places = np.array([reach * (1.0 - np.cos(angle)), reach * np.sin(angle)]) @ to_series
    found = np.zeros((6, _SAMPLES))
    found[4, : len(pitch)] = pitch
    for row, series in zip((0, 2), places, strict=True):
        powers = np.polynomial.Polynomial.cast(np.polynomial.Chebyshev(series, [0, 1])).coef
        found[row, : len(powers)] = powers
    return found


def objective_of(trans: Transcription, x: Array, pieces: list[tuple[Piece, ...]]) -> float:
    """J of eq. (16) over the finished curves: τᵀτ of all joints and ρ uᵀu, s."""
    nodes, shares = np.polynomial.legendre.leggauss(_SAMPLES)
    found, weights = 0.0, trans.settings.weights(trans.biped.robot.joint_names)
    for phase, group in enumerate(pieces):
        for piece in group:
            s = 0.5 * (nodes + 1.0)
            u = _wrench_at(trans, x, phase, piece.start + s * piece.duration)
            if trans.layout.leans and trans.motion.phases[phase].double:  # scaled; about the sole's origin
                u = (
                    chebyshev(piece.wrench, s)[:6]
                    if trans.motion.phases[phase].support == "right"
                    else chebyshev(piece.wrench, s)[6:]
                )
            effort = weights @ chebyshev(piece.torque, s) ** 2
            effort = effort + trans.settings.wrench_weight * np.sum(u**2, axis=0)
            found += 0.5 * piece.duration * float(shares @ effort)
    return found


def _trimmed(series: Array) -> Array:
    """Series without trailing coefficients that are all negligible."""
    size = np.abs(series).max(axis=0)
    floor = _TRIFLE * max(float(size.max()), 1.0)
    keep = np.flatnonzero(size > floor)
    return series[:, : (int(keep[-1]) + 1 if len(keep) else 1)].copy()
