"""The plan that answers a request: one gait, or several joined to a walk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.files.gait_file import claims_hash
from gaitsmith.synthesis.files.motion_file import read_motion
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import Gait, follow, moved_value
from gaitsmith.synthesis.motions.biped import REST, Biped, standing
from gaitsmith.synthesis.motions.catalogue import cyclic, jump, kick, start, stop
from gaitsmith.synthesis.motions.motion import At, Condition, Motion, Same
from gaitsmith.synthesis.motions.quantities import QUANTITIES
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.motions.stairs import check_stairs, stairs_cycle, stairs_start, stairs_stop
from gaitsmith.synthesis.motions.turning import check_turn, turn_cycle, turn_start, turn_stop
from gaitsmith.synthesis.requests.asked import ON_LINES, Request
from gaitsmith.synthesis.requests.free_times import freed_motion, freed_step
from gaitsmith.synthesis.solution.certificate import mirrored_entry
from gaitsmith.synthesis.solution.ipopt import Progress
from gaitsmith.synthesis.solution.plan import Planner, PlanResult

Array = npt.NDArray[np.float64]
_ENDS = ("value", "limit")  # of an entry of the certificate, with a place in the world
_FASTER = 0.7  # of a period at which there is no gait: the next one that is tried
_FASTEST = 1.2  # times the square root of leg over gravity: no shorter period is tried
_REPORT = Callable[[str, int, Progress], None]


@dataclass(frozen=True, eq=False)
class Answer:
    """The results of all solves that a request took, and its gait.

    Attributes:
        results: by name of the motion, in the order of solving.
        gait: None unless all of them solved.
        periods: of a step, at which there was no gait before one was tried that counts, s.
        main: the result that counts for the request.
    """

    results: dict[str, PlanResult]
    gait: Gait | None
    periods: tuple[float, ...] = ()

    @property
    def main(self) -> PlanResult:
        """The last result: the one asked for, or the one that failed."""
        return list(self.results.values())[-1]


def answer(planner: Planner, request: Request, report: _REPORT | None = None) -> Answer:
    """Plan what a request asks for.

    Args:
        planner: for the robot.
        request: what to plan.
        report: called at every iteration with the motion's name, the round and the progress.

    Raises:
        BadInput: numbers that cannot be used.
    """
    biped, settings = planner.biped, request.settings
    if biped.lines and request.kind not in ON_LINES:
        valid = f"{', '.join(ON_LINES)}, or a motion file, for a robot whose soles are lines"
        raise BadInput("MOTION", request.kind, valid, "it does not stand still on one of them")
    results: dict[str, PlanResult] = {}

    def run(motion: Motion, chosen: Settings, neighbour: PlanResult | None = None) -> PlanResult:
        tell = None if report is None else lambda rounds, progress: report(motion.name, rounds, progress)
        results[motion.name] = planner.plan(motion, chosen, neighbour=neighbour, report=tell)
        return results[motion.name]

    squat = max(REST * biped.height, settings.sized(biped).bounds.squat)
    rest = standing(biped, biped.height - squat, request.step.slope)
    if request.kind == "kick":
        return Answer(results, run(kick(biped, request.kick, rest), settings).gait)
    if request.kind == "jump":
        return Answer(results, run(jump(biped, request.jump, rest), settings).gait)
    if request.kind == "stairs":
        check_stairs(biped, request.step)
        cycle = run(stairs_cycle(biped, request.step), request.settings)
        return _ends(planner, request, run, results, cycle, rest)
    if request.kind == "turn":
        check_turn(biped)
        cycle = run(turn_cycle(biped, request.step, settings.sized(biped).bounds.foot_gap), settings)
        return _ends(planner, request, run, results, cycle, rest)
    step, periods = request.step, []
    cycle = run(cyclic(biped, step), request.settings)
    while request.faster and cycle.gait is None and _FASTER * step.period > _FASTEST * biped.fall_time:
        periods.append(step.period)
        step = replace(step, period=_FASTER * step.period, length=_FASTER * step.length)
        cycle = run(cyclic(biped, step), request.settings)
    if request.free_times and cycle.gait is not None:
        step, cycle = freed_step(planner, step, cycle, settings, lambda tried, best: run(tried, settings, best))
        results["cyclic"] = cycle
    return replace(_ends(planner, replace(request, step=step), run, results, cycle, rest), periods=tuple(periods))


def _ends(
    planner: Planner,
    request: Request,
    run: Callable[[Motion, Settings, PlanResult], PlanResult],
    results: dict[str, PlanResult],
    cycle: PlanResult,
    rest: Array,
) -> Answer:
    """What a request wants beside the cyclic gait: a start, a stop, or both."""
    biped, settings = planner.biped, request.settings
    if request.kind == "cyclic" or cycle.gait is None:
        return Answer(results, cycle.gait)
    q, v, a = cycle.gait.joints(0, np.array([0.0]))
    state = (q[biped.index, 0], v[biped.index, 0], a[biped.index, 0])
    first, last = start, stop
    if request.kind == "stairs":
        first, last = stairs_start, stairs_stop
    elif request.kind == "turn":
        gap = settings.sized(biped).bounds.foot_gap
        first, last = partial(turn_start, gap=gap), partial(turn_stop, gap=gap)
    begin = run(first(biped, request.step, rest, state), settings, cycle) if request.kind != "stop" else None
    if begin is not None and (begin.gait is None or request.kind == "start"):
        return Answer(results, begin.gait)
    closing = last(biped, request.step, rest, state)
    closing = replace(closing, conditions=closing.conditions + leaning(biped, cycle.gait))
    end = run(closing, settings, cycle)
    if request.kind == "stop" or begin is None or end.gait is None or begin.gait is None:
        return Answer(results, end.gait)
    return Answer(results, _joined(planner, request, begin, cycle, end))


def leaning(biped: Biped, gait: Gait) -> tuple[Condition, ...]:
    """What a motion that begins as a gait does shares beside its joints: the lean of a line sole, and its rate.

    They are those with which the other sole is on the ground and its ankle as fast as the gait's.
    """
    if not biped.lines:
        return ()
    phase, begin, finder = gait.motion.phases[0], np.array([0.0]), StateFinder(biped.robot)
    q, v, a = gait.joints(0, begin)
    finder.find(phase.support, phase.stand, q[:, 0], v[:, 0], a[:, 0], gait.roots(0, begin)[..., 0])
    leg = biped.leg(phase.other_foot)
    speed = finder.foot(phase.other_foot, -leg.sole_rotation.T @ leg.sole_position)[1]
    return At(0, "sole_z", 0.0), At(0, "ankle_vz", float(speed[2]))


def answer_file(planner: Planner, path: Path, report: _REPORT | None = None) -> Answer:
    """Plan the motion in a file.

    Raises:
        BadInput: as :func:`gaitsmith.synthesis.files.motion_file.read_motion`.
    """
    motion, settings = read_motion(path, planner.biped)
    tell: Any = None if report is None else lambda rounds, progress: report(motion.name, rounds, progress)
    found = planner.plan(motion, settings, report=tell)
    if found.gait is not None and any(phase.between is not None for phase in motion.phases):

        def again(tried: Motion, best: PlanResult) -> PlanResult:
            return planner.plan(tried, settings, neighbour=best, report=tell)

        found = freed_motion(planner, motion, found, settings, again)
    return Answer({motion.name: found}, found.gait)


def _joined(planner: Planner, request: Request, begin: PlanResult, cycle: PlanResult, end: PlanResult) -> Gait:
    """Start, cycles and stop as one gait."""
    assert begin.gait is not None
    assert cycle.gait is not None
    assert end.gait is not None
    partner, sign = planner.biped.whole.partner, planner.biped.whole.sign
    gaits, sources, mirrored = [begin.gait], [begin.gait], cycle.gait.motion.mirrored
    if request.cycles % cycle.gait.motion.steps:
        raise BadInput("--cycles", request.cycles, "an even number of steps: this robot's left and right ones differ")
    for step in range(request.cycles // cycle.gait.motion.steps):
        gaits.append(follow(gaits[-1], cycle.gait, mirrored and step % 2 == 1, partner, sign))
        sources.append(cycle.gait)
    gaits.append(follow(gaits[-1], end.gait, mirrored and request.cycles % 2 == 1, partner, sign))
    sources.append(end.gait)
    phases = tuple(phase for gait in gaits for phase in gait.motion.phases)
    pieces = tuple(group for gait in gaits for group in gait.pieces)
    parameters = cycle.gait.motion.parameters | {"cycles": float(request.cycles)}
    bounds = begin.gait.bounds | {"torque_rate": max(gait.bounds["torque_rate"] for gait in gaits)}
    conditions: list[Condition] = []
    worst: dict[str, dict[str, Any]] = {}
    borders = 0
    for gait, source in zip(gaits, sources, strict=True):
        away = gait.motion.phases[0].stand[0] - source.motion.phases[0].stand[0]
        climb = gait.motion.phases[0].height - source.motion.phases[0].height
        first, mirror = gait.pieces[0][0].start, gait.motion.phases[0].support != source.motion.phases[0].support
        conditions += [_later(item, borders) for item in gait.motion.conditions]
        borders += len(gait.motion.phases)
        for item in gait.certificate["worst"]:
            moved = (mirrored_entry(item, planner.biped.whole) if mirror else item) | {"time": item["time"] + first}
            if moved["constraint"].endswith("torque rate"):  # every part may have its own bound
                most, value = bounds["torque_rate"], moved["value"]
                moved |= {"limit": float(np.copysign(most, value)), "violation": (abs(value) - most) / (2.0 * most)}
            if moved["constraint"] in QUANTITIES:
                ends = ((key, moved_value(moved["constraint"], moved[key], (away, 0.0, climb), 1.0)) for key in _ENDS)
                moved |= dict(ends)
            if moved["constraint"] not in worst or moved["violation"] > worst[moved["constraint"]]["violation"]:
                worst[moved["constraint"]] = moved
    solver = {
        name: found.gait.solver
        for name, found in (("start", begin), ("cyclic", cycle), ("stop", end))
        if found.gait is not None
    }
    ranked = sorted(worst.values(), key=lambda item: -float(item["violation"]))
    gait = replace(
        begin.gait,
        motion=Motion(request.kind, phases, tuple(conditions), False, parameters, slope=cycle.gait.motion.slope),
        pieces=pieces,
        bounds=bounds,
        solver=solver,
        certificate=begin.gait.certificate
        | {"worst": ranked, "objective": sum(float(gait.certificate["objective"]) for gait in gaits)},
    )
    gait.certificate["claims"] = claims_hash(gait)
    return gait


def _later(item: Condition, borders: int) -> Condition:
    """A condition of a motion that follows on ``borders`` phases."""
    if isinstance(item, Same):
        return replace(item, border=item.border + borders, other=item.other + borders)
    return replace(item, border=item.border + borders)
