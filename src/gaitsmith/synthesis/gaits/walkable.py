"""Gait files in a row as a plan that a controller can follow: start, a cyclic gait's steps repeated, stop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.planned import ContactPhase, Plan, PlanTable, Schedule
from gaitsmith.planned.schedule import BY_CLOCK, BY_CONTACT
from gaitsmith.planned.table import ENDLESS, PER_SOLE, SOLES, TERMS, lap_of
from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait, Piece, follow, polynomial, root_of
from gaitsmith.synthesis.gaits.plan_sections import Sections
from gaitsmith.synthesis.motions.biped import biped_from
from gaitsmith.synthesis.motions.motion import Phase, about_vertical
from gaitsmith.whole_body.reference import FLAT, HEEL, NONE, TOE

Array = npt.NDArray[np.float64]
_Row = list[tuple[Phase, tuple[Piece, ...]]]
_KINDS = {"air": NONE, "flight": NONE, "flat": FLAT, "heel": HEEL, "toe": TOE}
_SEAM = 1e-3  # rad: joints where one gait follows another
_RESTING = 1e-6  # rad/s
_BALL_RANGE = 2.0  # m
MOST_CYCLES = 10_000


def walkable(gaits: Sequence[Gait], robot: Robot, cycles: int | None = None) -> Plan:
    """The plan that gaits in a row make up.

    Args:
        gaits: each begins where the one before ends; of a cyclic one every second step is mirrored.
        robot: the robot that they were planned for.
        cycles: steps of the cyclic gait, an even number if it is a stride; None: endless if it is the last, else two.

    Raises:
        BadInput: a gait for another robot, cycles without a cyclic gait or out of range, gaits that do not follow one
            another, or a schedule that contradicts its contacts.
    """
    for gait in gaits:
        if gait.joint_names != robot.joint_names or gait.robot_hash != robot.content_hash:
            valid = f"the robot that the gait was planned for, {gait.robot[:60]} with hash {gait.robot_hash[:12]}"
            raise BadInput("--robot", robot.card.name, valid, "plan again for this one")
    cyclic = sum(gait.motion.cyclic for gait in gaits)
    if cyclic > 1:
        raise BadInput("--gait", f"{cyclic} cyclic gaits", "one at most")
    if cycles is not None and not cyclic:
        raise BadInput("--cycles", cycles, "nothing for a gait that is not cyclic", "give a cyclic gait")
    if cycles is not None and not 1 <= cycles <= MOST_CYCLES:
        raise BadInput("--cycles", cycles, f"1 to {MOST_CYCLES}")
    row, loop = _in_a_row(gaits, robot, cycles)
    contacts = _contacts(row, robot)
    Schedule(tuple(contacts))
    if loop is not None:
        Schedule(tuple(contacts[loop[0] : loop[1]]), cyclic=True)
    slopes = {gait.motion.slope for gait in gaits}
    if len(slopes) > 1:
        raise BadInput("--gait", f"slopes of {sorted(slopes)} rad", "gaits for one slope")
    sections = Sections(robot, slopes.pop())
    sequence: list[int] = []
    first_visits: list[int] = []
    before: Phase | None = None
    for contact, (phase, pieces), begin, frame in zip(
        contacts, row, _stretches(contacts), _frames(row, contacts, loop, sections), strict=True
    ):
        first_visits.append(len(sequence))
        within = begin[0]
        for piece in pieces:
            seen = contact, frame
            if before is not None and before.tips and piece is pieces[0]:
                seen = _from_other(contact, frame)  # a sole that lands becomes the support once it has a place
            sequence += sections.add(seen[0], piece, (within, begin[1]), seen[1], contact.support)
            within += piece.duration
        before = phase
    first_visits.append(len(sequence))
    visits = (0, len(sequence), 1) if loop is None else (first_visits[loop[0]], first_visits[loop[1]], loop[2])
    return _described(gaits, row, loop, sections, sections.table(sequence, visits))


def _in_a_row(gaits: Sequence[Gait], robot: Robot, cycles: int | None) -> tuple[_Row, tuple[int, int, int] | None]:
    """All phases in order of time, and which are repeated: first, the one after the last, and how often."""
    biped = biped_from(robot)
    row: _Row = []
    before: Gait | None = None
    loop: tuple[int, int, int] | None = None
    for index, gait in enumerate(gaits):
        wanted = once = 1
        if gait.motion.cyclic:
            endless = cycles is None and index == len(gaits) - 1
            steps, once = 2 if cycles is None else cycles, 2 // gait.motion.steps  # in a stride
            if steps % gait.motion.steps:
                raise BadInput("--cycles", steps, "an even number of steps: the gait's left and right ones differ")
            wanted = steps // gait.motion.steps
            if steps > 1:
                loop = (len(row), 0, ENDLESS if endless else steps // 2)
        for step in range(min(wanted, once + wanted % once)):
            if before is not None:
                mirror = gait.motion.phases[0].support != before.motion.phases[-1].support
                _check_seam(before, gait, mirror, robot)
                before = follow(before, gait, mirror, biped.partner, biped.sign)
            else:
                before = gait
            row += zip(before.motion.phases, before.pieces, strict=True)
            if loop is not None and loop[1] == 0 and step == once - 1:
                loop = (loop[0], len(row), loop[2])
    return row, loop


def _check_seam(before: Gait, gait: Gait, mirror: bool, robot: Robot) -> None:
    """Refuse a gait that does not begin in the posture in which the one before ends."""
    ends, begins = before.pieces[-1][-1].joints.sum(axis=1), gait.pieces[0][0].joints[:, 0]
    jump = float(np.abs(ends - (biped_from(robot).mirrored(begins) if mirror else begins)).max())
    if jump > _SEAM:
        valid = f"a gait that begins in the posture in which {before.motion.name} ends"
        raise BadInput("--gait", gait.motion.name, valid, f"joints jump by {jump:.3g} rad")


def _contacts(row: _Row, robot: Robot) -> list[ContactPhase]:
    """Every phase with the contacts of all soles, and what ends it."""
    names = [leg.name for leg in robot.legs]
    found = []
    for (phase, _), (later, _) in pairwise(row):
        if phase.flies and phase.foothold != later.foothold:
            raise BadInput("--gait", "a flight to another place", "one that lands where it began")
    for (phase, _), after in zip(row, [*row[1:], None], strict=True):
        support = names.index(phase.support)
        contact = [_KINDS[phase.contact]] * len(names)
        contact[support] = NONE if phase.flies else _KINDS[phase.support_contact]
        lands = not phase.double and after is not None and after[0].double
        end = BY_CONTACT if lands else BY_CLOCK
        found.append(ContactPhase(phase.name, phase.duration, support, tuple(contact), end))
    return found


def _stretches(contacts: list[ContactPhase]) -> list[tuple[float, float]]:
    """Of every phase, when it begins within its stretch, and the stretch's duration, s."""
    found: list[tuple[float, float]] = []
    first = 0
    while first < len(contacts):
        end = first
        while end < len(contacts) and contacts[end].bearing == contacts[first].bearing:
            end += 1
        starts = np.cumsum([0.0] + [phase.duration for phase in contacts[first:end]])
        found += [(float(start), float(starts[-1])) for start in starts[:-1]]
        first = end
    return found


def _frames(
    row: _Row, contacts: list[ContactPhase], loop: tuple[int, int, int] | None, sections: Sections
) -> list[tuple[Array, ...]]:
    """Of every phase, the soles' weights at both ends of its stretch, and their places relative to the support sole."""
    soles = len(sections.robot.legs)
    alone = [contact.support if sum(contact.bearing) == 1 else None for contact in contacts]
    world = np.zeros((soles, 4))
    found = []
    for index, ((phase, _), contact) in enumerate(zip(row, contacts, strict=True)):
        again = alone[loop[0] :] if loop is not None and index < loop[1] else []
        before = next((support for support in alone[index::-1] if support is not None), None)
        after = next((support for support in alone[index:] + again if support is not None), None)
        weights = [np.full(soles, 1.0 / soles) if k is None else np.eye(soles)[k] for k in (before, after)]
        world[contact.support] = (*phase.stand, phase.heading)
        if phase.other is not None:
            world[1 - contact.support] = (*phase.other, phase.other_height, phase.other_heading)
        standing = np.array(contact.bearing)[:, None]
        place = world - world[contact.support]
        place[:, :3] = place[:, :3] @ about_vertical(phase.heading) @ sections.finder.ground.T
        found.append((*weights, np.where(standing, place, 0.0)))
    return found


def _from_other(contact: ContactPhase, frame: tuple[Array, ...]) -> tuple[ContactPhase, tuple[Array, ...]]:
    """A phase of double support, and its frame, relative to the sole that is not its support."""
    other = 1 - contact.support
    weights, place = frame[:-1], frame[-1]
    return (
        (replace(contact, support=other), (*weights, place - place[other]))
        if all(contact.bearing)
        else (contact, frame)
    )


def _described(
    gaits: Sequence[Gait], row: _Row, loop: tuple[int, int, int] | None, sections: Sections, table: PlanTable
) -> Plan:
    """The table with what a run asks about the plan."""
    (first, first_pieces), (_, last_pieces) = row[0], row[-1]
    q, v, a = polynomial(first_pieces[0].joints, np.zeros(1), first_pieces[0].duration)[:, :, 0]
    began = sections.finder.find(first.support, first.stand, q, v, a, root_of(first_pieces[0], np.zeros(1))[..., 0])
    final = polynomial(last_pieces[-1].joints, np.ones(1), last_pieces[-1].duration)[1, :, 0]
    times = table.duration[table.sequence]
    duration, once = float(times.sum()), float(times[table.loop_first : table.loop_end].sum())
    if loop is not None:
        duration += (np.inf if table.passes == ENDLESS else table.passes - 1.0) * once
    strike, off = _foot_pitch(table)
    plan = Plan(
        name="+".join(gait.motion.name for gait in gaits),
        table=table,
        phases=tuple(sections.names),
        start=(began.position, began.velocity),
        at_rest=(bool(np.abs(v).max() < _RESTING), bool(np.abs(final).max() < _RESTING)),
        duration=duration,
        speed=0.0,
        height=float(np.average(table.motion[table.sequence, 0, 2], weights=times)),
        ball=_ball(gaits),
        foot_pitch=(strike, off),
    )
    speed = plan.way(duration).ahead / duration if loop is None else lap_of(table).ahead / once
    return replace(plan, speed=speed)


def _foot_pitch(table: PlanTable) -> tuple[float, float]:
    """Largest pitch of a sole at heel strike, toe up, and at toe-off, toe down, rad."""
    ends = np.array([(-1.0) ** np.arange(TERMS), np.ones(TERMS)])
    strike = off = 0.0
    for motion, contact in zip(table.motion, table.contact, strict=True):
        for row, kind in enumerate(contact):
            pitch = ends @ motion[:, SOLES + PER_SOLE * row + 4]
            strike = max(strike, float(-pitch.min())) if kind == HEEL else strike
            off = max(off, float(pitch.max())) if kind == TOE else off
    return strike, off


def _ball(gaits: Sequence[Gait]) -> tuple[float, float, float] | None:
    """Where the ankle meets the ball, m, and its planned speed, m/s; None for a gait without one.

    Raises:
        BadInput: a place that no kick reaches.
    """
    for gait in gaits:
        given = gait.motion.parameters
        if "ball_1" in given and "ball_2" in given:
            for key in ("ball_1", "ball_2"):
                if not abs(given[key]) <= _BALL_RANGE:
                    valid = f"-{_BALL_RANGE:g} to {_BALL_RANGE:g} m"
                    raise BadInput(f"parameters.{key}", given[key], valid, "plan it again")
            return given["ball_1"], given["ball_2"], given.get("speed", 0.0)
    return None
