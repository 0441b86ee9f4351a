"""Boundary constraints: closure of the feet (1)-(5), periodicity (6), the start, stop and kick conditions (21)-(31)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.motions.motion import At, Motion, Phase, Same, State, about_vertical, turned
from gaitsmith.synthesis.motions.quantities import of_joint, unit_of
from gaitsmith.synthesis.program.bounds import Kind
from gaitsmith.synthesis.program.quantities import Form, joint_form, quantity_form
from gaitsmith.synthesis.program.rows import Label, Rows
from gaitsmith.synthesis.program.transcription import Points, Transcription, flights_of, tips_of

Array = npt.NDArray[np.float64]
_MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
_PASSIVE = 10.0  # of the robot's unit of torque: rows of comparable size


def _point(points: Points, phase: int, time: float) -> int:
    """Index of the point of a phase at a time."""
    found = np.flatnonzero((points.control < 0) & (points.phase == phase) & (np.abs(points.time - time) < 1e-9))
    if len(found) == 0:
        raise BadInput("point", time, "an instant among the collocation points")
    return int(found[0])


def closure_rows(rows: Rows, trans: Transcription, points: Points) -> None:
    """Closure in position, velocity and acceleration at every knot of double support (the quartic: without the last).

    A foot that turns about an edge keeps the edge in place and its roll and yaw at zero; a flat one its pitch too. A
    line sole may roll: there its roll is its lean.
    """
    motion, knots = trans.motion, trans.spline.knots
    phases = motion.phases
    for index, phase in enumerate(phases):
        if not phase.double:
            continue
        first = trans.first_section[index]
        joined = index > 0 and (phases[index - 1].double or motion.takes_over(index))
        for k in range(phase.sections + 1):
            if k == 0 and joined:
                continue
            at_end = k == phase.sections
            flat = phase.contact == "flat" or (at_end and index + 1 < len(phases) and phases[index + 1].double)
            _close(rows, trans, _point(points, index, knots[first + k]), index, phase, flat, float(knots[first + k]))


def _close(rows: Rows, trans: Transcription, point: int, index: int, phase: Phase, flat: bool, time: float) -> None:
    layout = trans.layout
    base = point * layout.outputs
    pivot = trans.pivots[index]
    x, y = other_place(phase, pivot)
    cos, sin = math.cos(phase.bend), math.sin(phase.bend)
    label = Label(f"closure of the {phase.contact} foot", "m or rad", index, time, 1.0)
    for axis, value in enumerate((x, y, phase.rise)):
        rows.add(label, value, value, {base + layout.pivot + axis: 1.0})
    line = layout.leans > 0
    for name in ("lean_gap" if line else "foot_roll",) + (("foot_pitch",) if flat else ()):
        rows.add(label, 0.0, 0.0, {base + getattr(layout, name): 1.0})
    rows.add(label, 0.0, 0.0, _sum(base, {layout.foot_yaw: cos, layout.foot_forward: -sin}))
    # What may not turn: nothing at all, or nothing across the edge and about the vertical; a line turns with its lean.
    still = ({0: 1.0}, {1: 1.0}, {2: 1.0}) if flat else ({0: cos, 1: sin}, {2: 1.0})
    derivatives = (
        (layout.pivot_velocity, layout.foot_omega, layout.velocity, 1.0),
        (layout.pivot_acceleration, layout.foot_alpha, layout.acceleration, 0.1),
    )
    for speed, spin, rate, scale in derivatives[: 1 if trans.settings.order < 5 else 2]:
        for axis in range(3):
            rows.add(label, 0.0, 0.0, {base + speed + axis: scale})
        for form in still:
            lean = {point * layout.inputs + rate + layout.joints + 1: -scale} if line and 0 in form else {}
            rows.add(label, 0.0, 0.0, _sum(base + spin, {k: scale * f for k, f in form.items()}), inp=lean)


def other_place(phase: Phase, pivot: Array) -> tuple[float, float]:
    """Where a phase holds the other sole's pivot, from the support sole, in its frame."""
    other = phase.straight.other
    assert other is not None
    x, y = turned((float(pivot[0]), float(pivot[1])), phase.bend)
    return other[0] - phase.foothold[0] + x, phase.side * (other[1] - phase.foothold[1]) + y


def _sum(base: int, terms: Form) -> Form:
    """A form without the terms that are zero."""
    return {base + index: factor for index, factor in terms.items() if factor}


def passive_rows(rows: Rows, trans: Transcription, points: Points) -> None:
    """No moment about the line of a support sole: the equation of motion of its lean, at the collocation points.

    Where a phase follows another the border's point is the other's, or follows from the continuity of u.
    """
    motion, layout = trans.motion, trans.layout
    scale = _PASSIVE / trans.biped.effort
    _flight_rows(rows, trans, points)
    _edge_rows(rows, trans, points)
    for point in np.flatnonzero(points.weight > 0.0).tolist() if layout.leans else ():
        index, time = int(points.phase[point]), float(points.time[point])
        if (index or motion.cyclic) and abs(time - motion.borders[index]) < 1e-9:
            continue
        label = Label("moment about the sole's line", "N·m", index, time, 1.0 / scale)
        rows.add(label, 0.0, 0.0, {point * layout.outputs + layout.moment: scale})


def _flight_rows(rows: Rows, trans: Transcription, points: Points) -> None:
    """No wrench on a support sole that flies; at both ends of its flight it stands still, flat, at its footholds."""
    motion, layout, biped = trans.motion, trans.layout, trans.biped
    for point in np.flatnonzero(points.weight > 0.0).tolist():
        index, time = int(points.phase[point]), float(points.time[point])
        again = index and motion.phases[index - 1].flies and abs(time - motion.borders[index]) < 1e-9
        if not motion.phases[index].flies or again:
            continue
        for row in range(6):
            scale = 1.0 / biped.weight if row < 3 else _PASSIVE / biped.effort
            label = Label("wrench in flight", "N or N·m", index, time, 1.0 / scale)
            rows.add(label, 0.0, 0.0, {point * layout.outputs + layout.force + row: scale})
    for run in flights_of(motion):
        _ballistic_rows(rows, trans, points, run)
        first, last = motion.phases[run[0]], motion.phases[run[-1] + 1]
        ahead, aside = (b - a for a, b in zip(first.foothold, last.foothold, strict=True))
        goal = np.array([ahead, first.side * aside, last.height - first.height, 0.0, 0.0, 0.0])
        for phase, time, place in (
            (run[0], motion.borders[run[0]], np.zeros(6)),
            (run[-1], motion.borders[run[-1] + 1], goal),
        ):
            for derivative, scale in enumerate((1.0, 0.1, 0.01)):
                label = Label("place of the support sole at an end of its flight", "m or rad", phase, float(time), 1.0)
                matrix = trans.pose_rows(phase, float(time), derivative) * scale
                rows.add_linear(label, matrix, place if derivative == 0 else np.zeros(6))


def _edge_rows(rows: Rows, trans: Transcription, points: Points) -> None:
    """A support sole that turns about its toe's edge: no moment about that; flat and still where it is not yet turned.

    Where the other foot lands instead, that one is flat and still at its foothold then.
    """
    motion, layout = trans.motion, trans.layout
    scale = _PASSIVE / trans.biped.effort
    for run in tips_of(motion):
        begin, end = float(motion.borders[run[0]]), float(motion.borders[run[-1] + 1])
        for point in np.flatnonzero((points.weight > 0.0) & np.isin(points.phase, run)).tolist():
            index, time = int(points.phase[point]), float(points.time[point])
            if index == run[0] or abs(time - motion.borders[index]) > 1e-9:
                label = Label("moment about the toe's edge", "N·m", index, time, 1.0 / scale)
                rows.add(label, 0.0, 0.0, {point * layout.outputs + layout.edge: scale})
        after = motion.phases[run[-1] + 1]
        ends = [(run[0], begin)] + ([] if after.double else [(run[-1], end)])
        for index, time in ends:
            for derivative, factor in enumerate((1.0, 0.1, 0.01)):
                label = Label("pitch of the support foot", "rad", index, time, 1.0)
                rows.add_linear(label, trans.pose_rows(index, time, derivative) * factor, np.zeros(1))
        if after.double:
            landed = replace(motion.phases[run[-1]], contact="flat", other=after.foothold, other_height=after.height)
            _close(rows, trans, _point(points, run[-1], end), run[-1], landed, True, end)


def _ballistic_rows(rows: Rows, trans: Transcription, points: Points, run: list[int]) -> None:
    """Both ends of a flight lie on one parabola of the centre of mass, with one angular momentum about it.

    The wrench vanishes at the collocation points only: this is what it adds up to between them.
    """
    motion, layout = trans.motion, trans.layout
    begin, end = float(motion.borders[run[0]]), float(motion.borders[run[-1] + 1])
    one, two = (_point(points, k, t) * layout.outputs for k, t in ((run[0], begin), (run[-1], end)))
    span, weight = end - begin, -trans.biped.weight / trans.biped.robot.mass
    label = Label("momentum in flight", "m, m/s or m²/s", run[-1], end, 1.0)
    for axis in range(3):
        pull = weight if axis == 2 else 0.0
        place, speed = layout.com + axis, layout.momentum + axis
        fallen = 0.5 * pull * span**2
        rows.add(label, fallen, fallen, {two + place: 1.0, one + place: -1.0, one + speed: -span})
        rows.add(label, pull * span, pull * span, {two + speed: 1.0, one + speed: -1.0})
        turned = {two + layout.spin + axis: 1.0, one + layout.spin + axis: -1.0}
        if axis < 2:  # (c T + v T² / 2) × g
            across, sign = 1 - axis, -1.0 if axis == 0 else 1.0
            turned[one + layout.com + across] = sign * weight * span
            turned[one + layout.momentum + across] = sign * weight * 0.5 * span**2
        rows.add(label, 0.0, 0.0, turned)


def wrench_rows(rows: Rows, trans: Transcription, points: Points) -> None:
    """Continuity of u: zero where a foot meets or leaves the ground, continuous in between, no moment about an edge."""
    motion, layout = trans.motion, trans.layout
    phases = motion.phases
    for index, phase in enumerate(phases):
        if not phase.double:
            continue
        columns = trans.wrench_columns(index)
        start = float(motion.borders[index])
        label = Label("wrench of the other foot", "weights", index, start, 1.0)
        edge = phase.contact in ("heel", "toe")
        fixed: set[tuple[int, int]] = set()
        if layout.leans:
            fixed |= {(3, k) for k in range(4)}
        if motion.meets(index):
            fixed |= {(row, 0) for row in range(6)}
        if motion.leaves(index) or (layout.leans and index == len(phases) - 1 and _goes_on(motion)):
            fixed |= {(row, 3) for row in range(6)}
        for row, k in sorted(fixed):
            rows.add(label, 0.0, 0.0, lin={int(columns[row, k]): 1.0})
        cos, sin = math.cos(phase.bend), math.sin(phase.bend)
        for k in range(4) if edge else ():
            if (4, k) not in fixed:
                rows.add(label, 0.0, 0.0, lin=_sum(0, {int(columns[4, k]): cos, int(columns[3, k]): -sin}))
        if motion.takes_over(index):
            _taken_over(rows, trans, points, index, label)
        if index == 0 or not phases[index - 1].double:
            continue
        previous = phases[index - 1]
        here = _about_sole(trans, index, 0)
        same = previous.support == phase.support
        there = _about_sole(trans, index - 1, 3) if same else None
        point = _point(points, index - 1, start)
        frame = np.kron(np.eye(2), about_vertical(phase.bend))
        for row in range(6):
            if row == 3 and layout.leans:
                continue
            lin = dict(here[row])
            if there is not None:
                for column, value in there[row].items():
                    lin[column] = lin.get(column, 0.0) - value
                rows.add(label, 0.0, 0.0, lin=lin)
                continue
            # The wrench on the sole that was the support, seen in the mirrored frame of the new one.
            seen = -frame[row] * _MIRROR / trans.biped.weight
            rows.add(label, 0.0, 0.0, _sum(point * layout.outputs + layout.force, dict(enumerate(seen.tolist()))), lin)


def _goes_on(motion: Motion) -> bool:
    """Whether a motion ends in the midst of another one: with a whole state that is not at rest."""
    last = len(motion.phases)
    states = [item for item in motion.conditions if isinstance(item, State) and item.border == last]
    return any(item.velocity is not None and item.acceleration is not None and item.velocity.any() for item in states)


def _taken_over(rows: Rows, trans: Transcription, points: Points, index: int, label: Label) -> None:
    """U begins as the wrench, about the toe's edge, on the foot that bore all before, in the mirrored frame."""
    layout, before, weight = trans.layout, trans.motion.phases[index - 1], trans.biped.weight
    base = _point(points, index - 1, float(trans.motion.borders[index])) * layout.outputs
    columns = trans.wrench_columns(index)[:, 0]
    x, right, far = trans.biped.sole(before.support).ends[1]
    y = before.side * 0.5 * (right + far)
    force = base + layout.force
    forms: list[Form] = [{force + k: 1.0} for k in range(6)]
    forms[3] |= {force + 2: -y}  # M - r × F
    forms[5] |= {force + 1: -x, force: y}
    for row in (0, 1, 2, 3, 5):  # about the edge itself neither has a moment
        out = {k: -_MIRROR[row] * f / weight for k, f in forms[row].items() if f}
        rows.add(label, 0.0, 0.0, out, {int(columns[row]): 1.0})


def _about_sole(trans: Transcription, phase: int, coefficient: int) -> list[dict[int, float]]:
    """Six forms in x: u of a phase at its start (coefficient 0) or end (3), about the sole frame's origin, flat."""
    columns = trans.wrench_columns(phase)[:, coefficient]
    x, y = turned(tuple(trans.pivots[phase][:2].tolist()), trans.motion.phases[phase].bend)
    forms = [{int(column): 1.0} for column in columns]
    for row, column, lever in ((3, 2, y), (4, 2, -x), (5, 1, x), (5, 0, -y)):
        if lever:
            forms[row][int(columns[column])] = lever
    return forms


def condition_rows(rows: Rows, trans: Transcription, points: Points) -> None:
    """Conditions of the motion at its borders, and periodicity (6) with the second derivative."""
    motion = trans.motion
    borders = motion.borders
    for condition in motion.conditions:
        time = float(borders[condition.border])
        index = max(condition.border - 1, 0)
        if isinstance(condition, State):
            for derivative, values in enumerate((condition.position, condition.velocity, condition.acceleration)):
                if values is not None:
                    label = Label(f"joint state at border {condition.border}", "rad", index, time, 1.0)
                    scale = (1.0, 0.1, 0.01)[derivative]
                    matrix = trans.state_rows(condition.border, derivative)[: len(values)]
                    rows.add_linear(label, matrix * scale, values * scale)
        elif isinstance(condition, Same):
            biped = trans.biped
            label = Label(f"the posture of border {condition.other}", "rad", index, time, 1.0)
            there = trans.state_rows(condition.other, 0)[: biped.joints]
            if condition.mirrored:
                there = there[biped.partner].multiply(biped.sign[:, None])
            matrix = trans.state_rows(condition.border, 0)[: biped.joints] - there
            rows.add_linear(label, _compressed(matrix), np.zeros(biped.joints))
        elif isinstance(condition, At) and of_joint(condition.quantity) is not None:
            out, inp, span = joint_form(trans.biped, motion.phases[index], condition.quantity)
            unit, point = unit_of(condition.quantity), _point(points, index, time)
            label = Label(condition.quantity, unit, index, time, span, kind=Kind.REQUEST, exact=True)
            outs, inps = (
                {point * count + k: factor / span for k, factor in form.items()}
                for form, count in ((out, trans.layout.outputs), (inp, trans.layout.inputs))
            )
            rows.add(label, condition.value / span, condition.value / span, outs, inp=inps)
        elif isinstance(condition, At):
            form, constant = quantity_form(trans.biped, motion.phases[index], condition.quantity)
            point = _point(points, index, time)
            base = point * trans.layout.outputs
            value = condition.value - constant
            unit = unit_of(condition.quantity)
            label = Label(condition.quantity, unit, index, time, 1.0, constant, unit == "rad", Kind.REQUEST, True)
            rows.add(label, value, value, {base + k: factor for k, factor in form.items()})
    if motion.cyclic:
        _periodic_rows(rows, trans, motion)


def _periodic_rows(rows: Rows, trans: Transcription, motion: Motion) -> None:
    last = len(motion.phases)
    n = trans.biped.channels
    partner, sign = trans.biped.image if motion.mirrored else (np.arange(n), np.ones(n))
    for derivative, scale in enumerate((1.0, 0.1, 0.01)):
        start = trans.state_rows(0, derivative)[partner].multiply(sign[:, None])
        matrix = (trans.state_rows(last, derivative) - start) * scale
        label = Label("periodicity", "rad", last - 1, float(motion.borders[-1]), 1.0)
        rows.add_linear(label, _compressed(matrix), np.zeros(n))


def _compressed(matrix: sp.spmatrix) -> sp.csr_matrix:
    """A matrix in compressed rows, without stored zeros."""
    found = sp.csr_matrix(matrix)
    found.eliminate_zeros()
    return found
