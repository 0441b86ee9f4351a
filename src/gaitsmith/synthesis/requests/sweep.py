"""The grid of speeds and periods: which cyclic gaits exist for a robot, and why the others do not."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gaitsmith.robots import load_robot
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.settings import Bounds, Settings
from gaitsmith.synthesis.proof.verify import verify
from gaitsmith.synthesis.requests.nearby import plan_nearby
from gaitsmith.synthesis.solution.plan import Planner, PlanResult
from gaitsmith.work.workers import workers

SPEEDS = tuple(float(v) for v in np.linspace(0.05, 0.5, 8))
PERIODS = tuple(float(t) for t in np.linspace(0.4, 1.0, 5))
REACH = 0.30  # m, longest step of the grid
MARGIN = 0.01  # m


@dataclass(frozen=True)
class Cell:
    """One gait of the grid.

    Attributes:
        speed: m/s.
        period: s.
        length: of a step, m.
        reachable: whether the step is at most 0.30 m.
        status: ``certified``, ``failed``, or ``beyond reach``.
        reason: why not, in words.
        objective: J, 0 unless certified.
        iterations: of all solves.
        time_s: spent.
        zmp_margin_mm: found by :func:`verify`, 0 unless certified.
        warm: whether the plan comes from that of the period before.
    """

    speed: float
    period: float
    length: float
    reachable: bool
    status: str
    reason: str = ""
    objective: float = 0.0
    iterations: int = 0
    time_s: float = 0.0
    zmp_margin_mm: float = 0.0
    warm: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return dict(vars(self))


def sweep_row(robot: str, speed: float, periods: tuple[float, ...]) -> list[Cell]:
    """All periods at one speed, each solved from its neighbour where there is one."""
    loaded = load_robot(robot)
    planner = Planner(loaded)
    settings = Settings(bounds=Bounds(zmp_margin=MARGIN))
    cells: list[Cell] = []
    neighbour: PlanResult | None = None
    for period in periods:
        length = speed * period
        cell = Cell(speed, period, length, length <= REACH + 1e-9, "beyond reach", f"a step of {length:.3f} m")
        if cell.reachable:
            begin = time.perf_counter()
            motion = cyclic(planner.biped, StepParameters(length, period))
            found, warm = plan_nearby(planner, motion, settings, neighbour)
            spent = time.perf_counter() - begin
            cell = replace(cell, status="failed", reason=found.reason, iterations=found.iterations, time_s=spent)
            cell = replace(cell, warm=warm)
            if found.gait is not None:
                neighbour, verdict = found, verify(found.gait, loaded)
                status, reason = ("certified", "") if verdict.ok else ("failed", "; ".join(verdict.problems[:2]))
                margin = verdict.zmp_margin
                cell = replace(cell, status=status, reason=reason, objective=found.objective, zmp_margin_mm=margin)
        cells.append(cell)
    return cells


def sweep(robot: str, jobs: int = 1, report: Callable[[int, int], None] | None = None) -> list[Cell]:
    """The whole grid.

    Args:
        robot: name or path.
        jobs: processes.
        report: called with the number of cells done, and of all.

    Raises:
        BadInput: the robot cannot be planned for.
    """
    _ = Planner(load_robot(robot)).functions  # compiles once, before the processes would all do it
    rows: dict[str, list[Cell]] = {}
    with workers(jobs) as crew:
        for speed in SPEEDS:
            crew.submit(f"{speed:g}", sweep_row, robot, speed, PERIODS)
        for _ in SPEEDS:
            key, row = crew.done()
            rows[key] = row
            if report is not None:
                report(len(rows) * len(PERIODS), len(SPEEDS) * len(PERIODS))
    return [cell for speed in SPEEDS for cell in rows[f"{speed:g}"]]


def sweep_document(cells: list[Cell]) -> dict[str, Any]:
    """What ``gaitsmith plan sweep --json`` prints."""
    reachable = [cell for cell in cells if cell.reachable]
    certified = [cell for cell in reachable if cell.status == "certified"]
    return {
        "motion": "sweep",
        "status": "solved" if len(certified) >= 0.95 * len(reachable) else "not solved",
        "reachable": len(reachable),
        "certified": len(certified),
        "warm": sum(cell.warm for cell in cells),
        "share": len(certified) / max(len(reachable), 1),
        "cells": [cell.as_dict() for cell in cells],
    }
