"""Planning: solve on few points, look at every bound between them, add points where one is violated, solve again."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.motions.biped import Biped, biped_from
from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.point.functions import PointFunctions, point_functions
from gaitsmith.synthesis.program.bounds import check_margin
from gaitsmith.synthesis.program.guess import default_start
from gaitsmith.synthesis.program.program import Pick, Program, all_picks, make_program
from gaitsmith.synthesis.program.transcription import Points, Transcription
from gaitsmith.synthesis.solution.certificate import ALLOWED, Worst, merge, ranked
from gaitsmith.synthesis.solution.closure import finished_pieces
from gaitsmith.synthesis.solution.dense import DenseCheck, check, close_picks, new_picks, with_times, worst_violation
from gaitsmith.synthesis.solution.failure import explain, lacking, out_of_reach
from gaitsmith.synthesis.solution.ipopt import Progress, Solution, solve_ipopt
from gaitsmith.synthesis.solution.relaxation import relaxed
from gaitsmith.synthesis.solution.sqp import solve_sqp

Array = npt.NDArray[np.float64]
_ENOUGH = 0.8 * ALLOWED  # what lies between the instants of the dense grid is far less than the rest
_AIM = 0.2 * ALLOWED  # violations above this are dealt with while others are
_CURVED = ("friction", "yaw moment")  # far from a solution these rows make the solver wander
_SELDOM = ("torque", *_CURVED)  # imposed only where the dense grid asks for it
_EXAMINATION = 20.0  # s, to find out why there is no solution
_NEAR = 0.3  # of a bound's range: rows that a neighbour keeps
_COLD_TOLERANCE = 1e-2  # of the first solve, when warm ones follow
_WARM_ITERATIONS = 12
_USUAL = 60  # iterations from standing still; who needs more has asked for too much, or for another start
_FAR = {  # slower, but it also arrives from afar
    "alpha_for_y": "primal",
    "bound_push": 0.01,
    "bound_frac": 0.01,
    "slack_bound_push": 0.01,
    "slack_bound_frac": 0.01,
    "mumps_scaling": 77,
    "mumps_permuting_scaling": 7,
}


@dataclass(frozen=True, eq=False)
class PlanResult:
    """How planning ended.

    Attributes:
        status: ``solved``, ``not solved`` or ``not certified``.
        reason: why not, in words; empty when solved.
        gait: the gait with its certificate; None unless solved.
        objective: J of eq. (16).
        iterations: of all solves together.
        rounds: how often points were added.
        fallbacks: how often a slower method had to take over.
        times: s: setup, compile, solve, check.
        variables: unknowns.
        constraints: rows of the last program.
        worst: every constraint's worst value, the worst first.
        x, picks, borders, solution: unknowns, imposed bounds, times of the borders and last solution, from which a
            neighbour starts warm.
    """

    status: str
    reason: str
    gait: Gait | None
    objective: float
    iterations: int
    rounds: int
    fallbacks: int
    times: dict[str, float]
    variables: int
    constraints: int
    worst: list[Worst]
    x: Array
    picks: list[Pick] = field(default_factory=list)
    borders: Array = field(default_factory=lambda: np.zeros(0))
    solution: Solution | None = None

    @property
    def solved(self) -> bool:
        """Whether there is a certified gait."""
        return self.status == "solved"


@dataclass(frozen=True, eq=False)
class _Tally:
    """What is known after a solve."""

    objective: float
    iterations: int
    rounds: int
    times: dict[str, float]
    trans: Transcription
    program: Program
    x: Array
    picks: list[Pick]
    found: Solution
    fallbacks: int

    def result(self, status: str, reason: str, worst: list[Worst], gait: Gait | None = None) -> PlanResult:
        """The result of planning."""
        return PlanResult(
            status,
            reason,
            gait,
            self.objective,
            self.iterations,
            self.rounds,
            self.fallbacks,
            self.times,
            self.trans.size,
            self.program.rows,
            worst,
            self.x,
            self.picks,
            self.trans.motion.borders,
            self.found,
        )


class Planner:
    """Plans motions for one robot; the compiled functions are loaded once.

    Args:
        robot: the robot.
        notify: told once when the dynamics are compiled, or when there is no compiler.

    Raises:
        BadInput: the robot has legs or soles that cannot be planned for.
    """

    def __init__(self, robot: Robot, notify: Callable[[str], None] | None = None) -> None:
        self.biped: Biped = biped_from(robot)
        self.functions: PointFunctions = point_functions(self.biped, notify)
        self._compile_s = self.functions.compile_s  # told once, by the first plan

    def plan(
        self,
        motion: Motion,
        settings: Settings | None = None,
        neighbour: PlanResult | None = None,
        start: Array | None = None,
        report: Callable[[int, Progress], None] | None = None,
    ) -> PlanResult:
        """Solve, check on the dense grid, refine, and certify.

        Args:
            motion: phases and conditions.
            settings: bounds, order, tolerances.
            neighbour: result for the same phases with nearby numbers, to start warm from.
            start: unknowns to start cold from; the default start if None.
            report: called at every iteration with the round and the progress.

        Raises:
            BadInput: the ZMP margin leaves nothing of the sole.
        """
        settings = settings or Settings()
        check_margin(self.biped, settings.bounds)
        begin = time.perf_counter()
        trans = Transcription(self.biped, motion, settings)
        impossible = out_of_reach(trans)
        if impossible:
            times = {"setup": time.perf_counter() - begin, "compile": 0.0, "solve": 0.0, "check": 0.0}
            return PlanResult("not solved", impossible, None, np.nan, 0, 0, 0, times, trans.size, 0, [], np.zeros(0))
        base = trans.points()
        found: Solution | None = None
        if neighbour is not None and len(neighbour.x) == trans.size:
            picks = scaled_picks(neighbour.picks, neighbour.borders, motion.borders)
            x, found = neighbour.x, neighbour.solution
        else:
            picks = seldom_left_out(trans, base)
            x = default_start(trans) if start is None else start
        begin_x = default_start(trans) if start is None else start
        times = {"setup": 0.0, "compile": self._compile_s, "solve": 0.0, "check": 0.0}
        iterations, rounds, fallbacks, relaxed_once = 0, 0, 0, False
        deadline = begin + settings.time_limit
        self._compile_s = 0.0
        times["setup"] += time.perf_counter() - begin
        while True:
            clock = time.perf_counter()
            points = with_times(trans, base, picks)
            program = make_program(trans, self.functions, points, picks)
            far = start is not None or relaxed_once
            tell = None if report is None else partial(report, rounds)
            found = self._solve(program, found, x, settings, deadline, rounds, far, tell)
            iterations += found.iterations
            fallbacks += found.fallbacks
            x = found.x
            times["setup"] += found.setup_s
            times["solve"] += time.perf_counter() - clock - found.setup_s
            z, o = program.evaluate(x)
            tally = _Tally(
                program.objective(z, o), iterations, rounds, times, trans, program, x, picks, found, fallbacks
            )
            if not found.solved:
                possible, reason = self._examined(trans, base, program, found, begin_x, deadline, tell)
                if possible is None or relaxed_once:
                    return tally.result("not solved", reason, [])
                picks, x, found, relaxed_once = seldom_left_out(trans, base), possible, None, True
                continue
            clock = time.perf_counter()
            checks = check(trans, self.functions, x, settings.dense)
            times["check"] += time.perf_counter() - clock
            beyond = worst_violation(checks)
            if beyond <= _ENOUGH:
                break
            if rounds >= settings.refinements or time.perf_counter() > deadline:
                worst = certificate(trans, checks)
                first = worst[0]
                text = f"{first.constraint} {first.value:.4g} of {first.limit:.4g} {first.unit} in {first.phase}"
                return tally.result("not certified", f"{text}, after {rounds} refinements", worst)
            picks = new_picks(trans, checks, picks, _AIM)
            rounds += 1
        worst = certificate(trans, checks)
        clock = time.perf_counter()
        near, found = near_picks(program, picks, found, o)
        tally = replace(tally, picks=close_picks(trans, checks, near), found=found)
        gait = self._gait(trans, x, worst, checks, tally)
        times["check"] += time.perf_counter() - clock
        return tally.result("solved", "", worst, gait)

    def _examined(
        self,
        trans: Transcription,
        base: Points,
        program: Program,
        found: Solution,
        start: Array,
        deadline: float,
        tell: Callable[[Progress], None] | None,
    ) -> tuple[Array | None, str]:
        """Unknowns that meet everything, if there are any after all; and the reason why not, in words."""
        late = time.perf_counter() > deadline
        reason = explain(trans, program, found, late)
        picks = [
            pick for pick in all_picks(trans, base) if not trans.bounds[pick.phase][pick.bound].name.endswith(_CURVED)
        ]
        whole = make_program(trans, self.functions, base, picks)
        limit = min(_EXAMINATION, trans.settings.time_limit)
        least = relaxed(whole, start, limit, tell)
        if least.excesses or least.unmet is not None:
            return None, lacking(trans, least)
        return (least.x if least.solved and not late else None), reason

    def _solve(
        self,
        program: Program,
        last: Solution | None,
        x: Array,
        settings: Settings,
        deadline: float,
        rounds: int,
        far: bool,
        tell: Callable[[Progress], None] | None,
    ) -> Solution:
        """Warm from the last solution if there is one, else (or if that fails) cold; ``far``: from no usual start."""
        if last is not None:
            multipliers = np.zeros(program.rows)
            count = min(program.rows, len(last.multipliers))
            multipliers[:count] = last.multipliers[:count]
            found = solve_sqp(program, x, multipliers, _WARM_ITERATIONS, deadline, rounds > 0, tell)
            if found.solved or time.perf_counter() > deadline:
                return found
        left = max(deadline - time.perf_counter(), 0.01)
        tolerance = max(settings.tolerance, _COLD_TOLERANCE) if rounds == 0 else settings.tolerance
        far = far or last is not None
        options = _FAR if far else None
        most = settings.max_iterations if far else min(settings.max_iterations, _USUAL)
        cold = solve_ipopt(program, x, tolerance, most, left, tell, options)
        if last is None:
            return cold
        return replace(cold, iterations=cold.iterations + found.iterations, fallbacks=found.fallbacks + 1)

    def _gait(
        self, trans: Transcription, x: Array, worst: list[Worst], checks: list[DenseCheck], tally: _Tally
    ) -> Gait:
        """The gait in the robot's own order and world axes."""
        robot = self.biped.robot
        pieces = [finished_pieces(trans, self.functions, x, phase, item.pieces) for phase, item in enumerate(checks)]
        solver: dict[str, Any] = {
            "name": "IPOPT, SQP",
            "status": tally.found.status,
            "iterations": tally.iterations,
            "rounds": tally.rounds,
            "fallbacks": tally.fallbacks,
            "objective": tally.objective,
            "unknowns": x.tolist(),
        }
        return Gait(
            robot=robot.card.name,
            robot_hash=robot.content_hash,
            joint_names=robot.joint_names,
            motion=trans.motion,
            pieces=tuple(pieces),
            bounds=trans.settings.bounds.model_dump(),
            order=trans.settings.order,
            solver=solver,
            certificate={"dense_points": trans.settings.dense, "worst": [item.as_dict() for item in worst]},
        )


def certificate(trans: Transcription, checks: list[DenseCheck]) -> list[Worst]:
    """Every constraint's worst value, the worst first."""
    found: dict[str, Worst] = {}
    for phase, bounds, item in zip(trans.motion.phases, trans.bounds, checks, strict=True):
        merge(found, phase, bounds, item.times, item.values)
    return ranked(found)


def seldom_left_out(trans: Transcription, base: Points) -> list[Pick]:
    """All bounds at all points, without those that are imposed only where the dense grid asks for them."""
    return [pick for pick in all_picks(trans, base) if not trans.bounds[pick.phase][pick.bound].name.endswith(_SELDOM)]


def near_picks(program: Program, picks: list[Pick], found: Solution, o: Array) -> tuple[list[Pick], Solution]:
    """The picks that lie near their bounds, and the solution's multipliers without those of the others.

    A neighbour starts with these, and with the instants at which it may meet its bounds; the dense grid sees
    to the rest.
    """
    first = program.rows - len(picks)
    rows = program.constraint(found.x, o)
    room = np.minimum(program.high - rows, rows - program.low)[first:]
    keep = np.flatnonzero(room < _NEAR)
    multipliers = np.concatenate([found.multipliers[:first], found.multipliers[first:][keep]])
    return [picks[k] for k in keep], replace(found, multipliers=multipliers)


def scaled_picks(picks: list[Pick], old: Array, new: Array) -> list[Pick]:
    """Picks of one motion at the same shares of the phases of another."""
    found = []
    for pick in picks:
        share = (pick.time - old[pick.phase]) / (old[pick.phase + 1] - old[pick.phase])
        time = new[pick.phase] + share * (new[pick.phase + 1] - new[pick.phase])
        found.append(Pick(pick.phase, pick.bound, float(time), pick.tighten))
    return found
