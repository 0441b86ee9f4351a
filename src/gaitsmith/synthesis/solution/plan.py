"""Planning: solve on few points, look at every bound between them, add points where one is violated, solve again."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.synthesis.files.gait_file import claims_hash
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.worst import Worst
from gaitsmith.synthesis.motions.biped import Biped, biped_from
from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.point.functions import PointFunctions, point_functions
from gaitsmith.synthesis.program.bounds import check_margin, check_roots
from gaitsmith.synthesis.program.guess import default_start
from gaitsmith.synthesis.program.margin import MARGIN
from gaitsmith.synthesis.program.program import CURVED, SELDOM, ImposedBound, Program, every_bound, make_program
from gaitsmith.synthesis.program.transcription import Points, Transcription
from gaitsmith.synthesis.solution.bound_check import (
    BoundCheck,
    Tables,
    check_bounds,
    with_close,
    with_times,
    with_violated,
    worst_excess,
)
from gaitsmith.synthesis.solution.certificate import certificate, ranked
from gaitsmith.synthesis.solution.curves_from_solution import finished_pieces, objective_of
from gaitsmith.synthesis.solution.diagnose import lacking, undecided
from gaitsmith.synthesis.solution.elastic import Elastic, solve_elastic
from gaitsmith.synthesis.solution.geometry import out_of_reach
from gaitsmith.synthesis.solution.held import held_margins, of_all_joints, with_held
from gaitsmith.synthesis.solution.ipopt import Progress, Solution, solve_ipopt
from gaitsmith.synthesis.solution.neighbour import alike, near_bounds, rescaled, start_from
from gaitsmith.synthesis.solution.rate_check import (
    asked_too_fast,
    fastest,
    largest_rate,
    too_fast,
    torque_rates_of,
    with_fast,
)
from gaitsmith.synthesis.solution.relaxation import Before, Relaxation
from gaitsmith.synthesis.solution.sqp import solve_sqp

Array = npt.NDArray[np.float64]
_AIM = 0.2 * MARGIN  # violations above this are dealt with while others are
_COLD_TOLERANCE = 1e-2  # of the first solve, when warm ones follow
_CLOSE = 0.02  # of a range: while a bound is exceeded by more, a rough solution says where
_ROUGH = 5  # rounds of that at most
_NEARLY = 3.0  # of a range: while a bound is exceeded by more, torque rates say nothing
_WARM_ITERATIONS = 12
_USUAL = 60  # iterations from standing still; who needs more has asked for too much, or for another start
_ANOTHER = 100  # where a warm start failed
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
        status: ``solved``, ``not solved`` (nothing solves it), ``not decided`` (the iterations are spent) or
            ``not certified`` (a bound is not kept between the points, or by a joint that is held).
        reason: why not, in words; empty when solved.
        variables: unknowns.
        times: s: setup, compile, solve, check.
        gait: the gait with its certificate; None unless solved.
        objective: J of eq. (16).
        iterations: of all solves together.
        rounds: how often points were added.
        fallbacks: how often a slower method took over: IPOPT, unless a ``start`` was given, or the elastic program.
        constraints: rows of the last program.
        worst: every constraint's worst value, the worst first.
        x, imposed, borders, solution: what a neighbour starts from: unknowns, bounds, times of borders, the last solve.
        default_rate: N·m/s, the default bound of torque rates where it left no gait; the gait has the one used.
    """

    status: str
    reason: str
    variables: int
    times: dict[str, float]
    gait: Gait | None = None
    objective: float = np.nan
    iterations: int = 0
    rounds: int = 0
    fallbacks: int = 0
    constraints: int = 0
    worst: list[Worst] = field(default_factory=list)
    x: Array = field(default_factory=lambda: np.zeros(0))
    imposed: list[ImposedBound] = field(default_factory=list)
    borders: Array = field(default_factory=lambda: np.zeros(0))
    solution: Solution | None = None
    default_rate: float | None = None

    @property
    def solved(self) -> bool:
        """Whether there is a certified gait."""
        return self.status == "solved"


class Planner:
    """Plans motions for one robot; the compiled functions are loaded once.

    Args:
        robot: the robot.
        notify: called once before the dynamics are compiled, or where there is no compiler.

    Raises:
        BadInput: the robot has legs or soles that cannot be planned for.
    """

    def __init__(self, robot: Robot, notify: Callable[[str], None] | None = None, free: Sequence[str] = ()) -> None:
        self.biped: Biped = biped_from(robot, free)
        self.notify = notify
        self._compile_s: float | None = None  # reported once, by the first plan
        self._others: dict[tuple[bool, ...], Planner] = {}

    @cached_property
    def functions(self) -> PointFunctions:
        """Of a point, compiled when they are first needed."""
        return point_functions(self.biped, self.notify)

    def suited(self, motion: Motion) -> Planner:
        """The same, or one whose functions know flights, places of the robot's mass or slopes, if a motion has them."""
        kind = motion.flies, motion.placed and not motion.flies, motion.slope != 0.0, motion.tips
        found = self if kind == self.biped.kind else self._others.get(kind)
        if found is None:
            found = self._others[kind] = Planner(self.biped.robot, self.notify)
            found.biped = self.biped.of_kind(*kind)
        return found

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
            neighbour: result to start from: warm if it is for the same phases with nearby numbers, else its curves.
            start: unknowns to start cold from; the default start if None.
            report: called at every iteration with the round and the progress.

        Raises:
            BadInput: the ZMP margin leaves nothing of the sole, or a line sole turns about its end.
        """
        if (suited := self.suited(motion)) is not self:
            return suited.plan(motion, settings, neighbour, start, report)
        settings = (settings or Settings()).sized(self.biped, motion.transfer, motion.lift)
        check_margin(self.biped, settings.bounds)
        check_roots(self.biped, motion, settings.order)
        compiled, begin = self.functions.compile_s if self._compile_s is None else 0.0, time.perf_counter()
        trans = Transcription(self.biped, motion, settings)
        relaxation, first, tables = Relaxation(trans), 0, Tables(trans)
        times = {"setup": 0.0, "compile": compiled, "solve": 0.0, "check": 0.0}
        result = PlanResult("not solved", out_of_reach(trans), trans.size, times, borders=motion.borders)
        if result.reason:
            times |= {"setup": time.perf_counter() - begin, "compile": 0.0}
            return result
        self._compile_s, base = 0.0, trans.points()
        usual = default_start(trans) if start is None else start
        imposed, x, found = list[ImposedBound](), usual, None
        if neighbour is not None and neighbour.gait is not None and not alike(neighbour.gait.motion, motion):
            x = start_from(trans, usual, neighbour.gait, neighbour.x)
        elif neighbour is not None and len(neighbour.x) == trans.size:
            imposed = rescaled(neighbour.imposed, neighbour.borders, motion.borders)
            x, found = neighbour.x, neighbour.solution
        imposed = imposed or every_bound(trans, base, SELDOM)
        examined, rough = False, True  # until bounds are exceeded by little
        times["setup"] += time.perf_counter() - begin
        while True:
            clock = time.perf_counter()
            program = make_program(trans, self.functions, with_times(trans, base, imposed), imposed)
            tell = None if report is None else partial(report, result.rounds)
            far, asked = start is not None or examined, start is not None and found is None and not examined
            left = max(settings.max_iterations - result.iterations, 1)
            most = left if far or motion.flies else min(left, _USUAL if found is None else _ANOTHER)
            easier = relaxation.imposes(imposed)
            found, slower = self._solve(program, found, x, settings, most, rough, far, easier, tell)
            x = found.x
            times["setup"] += found.setup_s
            times["solve"] += time.perf_counter() - clock - found.setup_s
            z, o = program.evaluate(x)
            result = replace(
                result,
                objective=program.objective(z, o),
                iterations=result.iterations + found.iterations,
                fallbacks=result.fallbacks + (slower and not asked),
                constraints=program.rows,
                x=x,
                imposed=imposed,
                solution=found,
            )
            if not found.solved:
                text = undecided(trans, program, found, result.iterations)
                left = settings.max_iterations - result.iterations
                if easier and left > 0 and (before := relaxation.restart()) is not None:
                    imposed, x, found, first = before.imposed, before.x, before.found, result.rounds
                    continue
                if examined or left <= 0:
                    return replace(result, status="not decided", reason=text)
                least = self._examined(trans, base, (usual, x), left, tell)
                result = replace(
                    result, iterations=result.iterations + least.iterations, fallbacks=result.fallbacks + 1
                )
                if not least.solved:
                    return replace(result, status="not decided", reason=text)
                if least.excesses or least.unmet is not None:
                    return replace(result, reason=lacking(trans, least))
                imposed, x, found, examined = every_bound(trans, base, SELDOM), least.x, None, True
                continue
            clock = time.perf_counter()
            checks = check_bounds(trans, self.functions, x, settings.dense, tables)
            rates = torque_rates_of(trans, self.functions, x, checks)
            times["check"] += time.perf_counter() - clock
            excess, last = worst_excess(checks), result.rounds - first >= settings.refinements
            kept, fast, asked = excess <= 0.0 and not rough, too_fast(trans, rates), asked_too_fast(trans, rates)
            if kept and (
                not (fast or relaxation.unbounded or asked)
                or (not asked and relaxation.accepts(largest_rate(rates), last))
            ):
                break
            if last and easier and (before := relaxation.restart()) is not None:
                imposed, x, found, first = before.imposed, before.x, before.found, result.rounds
                continue
            if last:
                worst = certificate(trans, checks)
                text = f"{worst[0] if not kept else fastest(trans, rates)}, after {result.rounds} refinements"
                return replace(result, status="not certified", reason=text, worst=worst)
            if relaxation.before is None and fast:
                relaxation.before = Before(imposed, x, found)
            imposed = with_violated(trans, checks, imposed, _AIM, not rough)
            if fast and excess < _NEARLY:
                imposed = with_fast(trans, rates, imposed, not rough)
            rough = rough and excess > _CLOSE and result.rounds < _ROUGH
            first += rough
            result = replace(result, rounds=result.rounds + 1)
        clock = time.perf_counter()
        near, found = near_bounds(program, imposed, found, o)
        imposed = with_close(trans, checks, near)
        made = self._gait(trans, checks, result)
        held = held_margins(self.biped, settings.bounds, made, settings.dense)
        gait, steep = relaxation.settled(made, self.biped.names, settings.dense)
        worst = ranked(held | steep | {item.constraint: item for item in certificate(trans, checks)})
        gait.certificate["claims"] = claims_hash(gait)
        gait.certificate["worst"] = [item.as_dict() for item in worst]
        times["check"] += time.perf_counter() - clock
        result = replace(result, worst=worst, imposed=imposed, solution=found, default_rate=relaxation.replaced)
        if held and max(item.violation for item in held.values()) > 0.0:
            text = f"{ranked(held)[0]}, held; free it, or change its home"
            return replace(result, status="not certified", reason=text)
        if settings.order > 4 and max(item.violation for item in steep.values()) > 0.0:
            return replace(result, status="not certified", reason=str(ranked(steep)[0]))
        return replace(result, status="solved", gait=gait)

    def _examined(
        self,
        trans: Transcription,
        base: Points,
        starts: tuple[Array, ...],
        left: int,
        tell: Callable[[Progress], None] | None,
    ) -> Elastic:
        """The least excess of bounds with which everything can be met, from several starts until there is none."""
        whole = make_program(trans, self.functions, base, every_bound(trans, base, CURVED))
        found, spent = None, 0
        for begin in starts:
            least = solve_elastic(whole, begin, left - spent, tell)
            spent += least.iterations
            if found is None or (least.solved and (not found.solved or least.total < found.total)):
                found = least
            if spent >= left or (found.solved and not found.total):
                break
        assert found is not None
        return replace(found, iterations=spent)

    def _solve(
        self,
        program: Program,
        last: Solution | None,
        x: Array,
        settings: Settings,
        left: int,
        rough: bool,
        far: bool,
        easier: bool,
        tell: Callable[[Progress], None] | None,
    ) -> tuple[Solution, bool]:
        """By quadratic programs; from afar, or where they fail, by IPOPT, and whether it was by that.

        ``far``: from no usual start. ``easier``: there is another program to try before a slower method.
        """
        tried = 0
        if last is not None or not far:
            found = solve_sqp(program, x, last, min(_WARM_ITERATIONS, left), rough, tell)
            if found.solved or easier or found.iterations >= left:
                return found, False
            far, tried = far or last is not None, found.iterations
        tolerance = max(settings.tolerance, _COLD_TOLERANCE) if rough else settings.tolerance
        cold = solve_ipopt(program, x, tolerance, left - tried, tell, _FAR if far else None)
        return replace(cold, iterations=cold.iterations + tried), True

    def _gait(self, trans: Transcription, checks: list[BoundCheck], result: PlanResult) -> Gait:
        """The gait in the robot's own order and world axes."""
        robot, settings, x = self.biped.robot, trans.settings, result.x
        pieces = [finished_pieces(trans, self.functions, x, k, item.pieces) for k, item in enumerate(checks)]
        pieces = with_held(trans.biped, trans.motion, pieces)
        status = "" if result.solution is None else result.solution.status
        solver: dict[str, Any] = {"name": "SQP, IPOPT", "status": status}
        solver |= {"asymmetry": trans.biped.asymmetry, "held": [robot.joint_names[k] for k in trans.biped.held]}
        solver |= {name: getattr(result, name) for name in ("iterations", "rounds", "fallbacks")}
        return Gait(
            robot=robot.card.name,
            robot_hash=robot.content_hash,
            joint_names=robot.joint_names,
            motion=of_all_joints(trans.biped, trans.motion),
            pieces=tuple(pieces),
            bounds=settings.bounds.model_dump(),
            order=settings.order,
            solver=solver,
            certificate={
                "dense_points": settings.dense,
                "objective": objective_of(trans, x, pieces),
                "wrench_weight": settings.wrench_weight,
                "effort_weights": dict(settings.effort_weights),
            },
        )
