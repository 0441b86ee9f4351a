"""Runs of planned gaits: the plan of a scenario, its ball, and how well it is followed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gaitsmith.compiled import Arena
from gaitsmith.control import Controller
from gaitsmith.planned import Plan
from gaitsmith.robots import Robot
from gaitsmith.simulation.loop import Observer
from gaitsmith.simulation.plan_errors import PLANNED, REAL, compare_with_plan, make_plan_errors
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.props import Ball
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.stages import ENTERED, LEFT
from gaitsmith.simulation.summary import BallReport, FootPitch, Tracking
from gaitsmith.simulation.terrain import Region
from gaitsmith.synthesis.files.gait_file import load_robot_of, read_gait
from gaitsmith.synthesis.gaits.walkable import walkable
from gaitsmith.whole_body.reference import NONE

SETTLE = 2.0  # s for which a run goes on after its plan has ended
_ENDLESS = 10.0  # s of a plan without an end
_SAMPLE = 10  # ticks between two looks at the ZMP
_PLACES = 33  # of a plan's way that are looked at


def completed(fields: Mapping[str, Any]) -> dict[str, Any]:
    """A scenario's plain values with the gait files' or the library's robot where none is given.

    Time for the whole plan, too.

    Raises:
        BadInput: a file that cannot be used.
    """
    found = dict(fields)
    if found.get("library"):
        from gaitsmith.library.folder import Folder

        return {"robot": Folder(found["library"]).spec()[0].robot} | found
    gaits = [read_gait(path)[0] for path in found["gait"]]
    if "robot" not in found:
        found["robot"] = load_robot_of(gaits[0]).card.name
    if gaits[0].motion.slope and "terrain" not in found:
        found["terrain"] = f"ramp:{math.degrees(gaits[0].motion.slope):.12g}"
    if "duration" not in found:
        from gaitsmith.robots import load_robot

        plan = walkable(gaits, load_robot(found["robot"]), found.get("cycles"))
        found["duration"] = _ENDLESS if math.isinf(plan.duration) else plan.duration + SETTLE * plan.at_rest[1]
    return found


def plan_of(scenario: Scenario, robot: Robot) -> Plan | None:
    """The plan that a scenario's gait files make up; None without one.

    Raises:
        BadInput: a file that cannot be used, or that is for another robot.
    """
    if not scenario.gait:
        return None
    return walkable([read_gait(path)[0] for path in scenario.gait], robot, scenario.cycles)


def balls_of(plan: Plan | None, robot: Robot) -> tuple[Ball, ...]:
    """The ball that a plan kicks: the toe meets it where the plan's ankle is."""
    if plan is None or plan.ball is None:
        return ()
    ball = Ball((0.0, 0.0, 0.0))
    x, y, _ = plan.ball
    return (Ball((x + robot.legs[0].sole.toe + ball.radius, y, ball.radius)),)


def region_of(plan: Plan | None, scenario: Scenario) -> Region:
    """Ground around the path of a plan, or of what is commanded."""
    if plan is None or scenario.library:
        return scenario.region()
    times = np.linspace(0.0, min(scenario.duration, plan.duration), _PLACES)
    x, y, _ = np.array([plan.way(float(time)) for time in times]).T
    region = scenario.region()
    (back, front), (right, left) = region
    return Region((back + x.min(), front + x.max()), (right + y.min(), left + y.max()))


class Tracked(Observer):
    """Watches how well a plan is followed; its x axis is the world's.

    Args:
        tell: told when the plan enters a loop and leaves it; None for a plan that is steered, whose orders say so.
    """

    def __init__(self, plan: Plan, controller: Controller, plant: Plant, tell: Callable[..., None] | None) -> None:
        self.plan, self._controller, self._plant, self._tell = plan, controller, plant, tell
        self._loops = plan.table.passes != 1
        self._begin = math.nan
        reference = controller.reference
        shared = (plant.torso_rotation, reference.torso_rotation, reference.contact, controller.sole_pitch)
        self._errors = Arena(make_plan_errors(*shared))
        self._zmp: list[float] = [0.0, 0.0]

    def observe(self, tick: int) -> bool:
        """Take note of a tick; never ends the run unless the plan has, in motion."""
        reference, plant, clock = self._controller.reference, self._plant, self._controller.plan_clock
        if self._tell is not None and (clock.ended[0] or clock.visit[0] >= self.plan.table.loop_end):
            self._tell({"plan": LEFT})
            self._tell = None
        elif self._tell is not None and self._loops and clock.visit[0] >= self.plan.table.loop_first:
            self._tell({"plan": ENTERED})
            self._loops = False
        if math.isnan(self._begin):
            self._begin = float(plant.com[0])
        compare_with_plan(self._errors.address)
        if tick % _SAMPLE == 0 and NONE in reference.contact and (real := plant.zmp()) is not None:
            bearing = reference.load * (reference.contact != NONE)
            planned = bearing @ (reference.sole_position[:, :2] + reference.cop) / max(bearing.sum(), 1e-9)
            self._zmp[0] += float(np.sum((planned - real) ** 2))
            self._zmp[1] += 1.0
        return self._controller.plan_ended and not self.plan.at_rest[1]

    @property
    def phase(self) -> str:
        """Name of the plan's phase."""
        table = self.plan.table
        found: str = self.plan.phases[table.phase[table.sequence[self._controller.plan_clock.visit[0]]]]
        return found

    def report(self, time: float) -> Tracking:
        """The run so far, which lasted for a time, s."""
        plan, clock = self.plan, self._controller.plan_clock
        found = self._errors.view
        strike, off = (math.degrees(total / count) if count else 0.0 for total, count in found.pitch.tolist())
        planned = [math.degrees(angle) for angle in plan.foot_pitch]
        ball = self._plant.balls[0] if self._plant.balls else None
        return Tracking(
            distance=0.0 if math.isnan(self._begin) else float(self._plant.com[0]) - self._begin,
            planned_distance=plan.way(min(time, plan.duration)).x,
            turn_deg=math.degrees(found.turn[REAL]),
            planned_turn_deg=math.degrees(found.turn[PLANNED]),
            tilt_deg=dict(zip(("roll", "pitch"), np.degrees(found.tilt).tolist(), strict=True)),
            zmp_rms_mm=1e3 * math.sqrt(self._zmp[0] / max(self._zmp[1], 1.0)),
            foot_pitch_deg=FootPitch(strike=strike, off=off, planned_strike=planned[0], planned_off=planned[1])
            if max(planned) > 0.0
            else None,
            ball=BallReport(speed=ball.top_speed, planned_speed=plan.ball[2], travel=ball.travel)
            if ball is not None and plan.ball is not None
            else None,
            phase=self.phase,
            ended=bool(clock.ended[0]),
        )
