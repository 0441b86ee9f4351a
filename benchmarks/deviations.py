"""What every deviation from the paper is worth: one at a time is set back to the paper's choice, and BHR-B2 walks.

Each row starts from the default preset and changes only the numbers named. Three things are run: a walk at 0.4 m/s,
a walk in place, and pushes of 40 N·s to four sides at two phases of the stride, in place, at a height of 0.66 m, each
survived if the robot is upright 3 s later.

With ``--preset paper`` the rows are what that preset does not take as printed: it walks from the first instant on,
without standing before, as in the paper, and is not pushed.

    python benchmarks/deviations.py [--preset paper] [--jobs N] [--only WORD] [--no-pushes] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from time import perf_counter
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from gaitsmith import Robot, Scenario, Simulation, load_robot
from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.reproduction.as_printed import (
    AT_ONCE,
    INERTIAL,
    OMITTED,
    ROLL,
    STANCE,
    Deviation,
    walk_with,
)
from gaitsmith.simulation import Push, Summary
from gaitsmith.work.workers import workers

IMPULSE = 40.0  # N·s
PUSHED_HEIGHT = 0.66  # m
DIRECTIONS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))  # forward, left, back, right
PHASES = (0.25, 0.75)  # the middle of either leg's stance
FAST = 0.4  # m/s


def deviations(robot: Robot) -> tuple[Deviation, ...]:
    paper = preset_parameters(robot, robot_scale(robot), "paper").model_dump()
    eq15 = {"deadbeat": 0.0, "prediction": 0.0, "mean_speed": 0.0}
    none = (0.0, 0.0)
    return (
        Deviation("default preset, nothing set back"),
        Deviation("paper preset", paper),
        Deviation("speed: no integral", {"speed": {"integral_gain": none}}),
        Deviation("speed: no station keeping", {"speed": {"station_gain": none}}),
        Deviation("step time: kept", {"step_time": {"shortest": 1.0}}),
        Deviation("foothold: present velocity, no forecast", {"foothold": {"prediction": 0.0}}),
        Deviation("foothold: fixed k_v 0.30 s", {"foothold": {"deadbeat": 0.0}}),
        Deviation("foothold: step T v_d from the hips", {"foothold": {"mean_speed": 0.0}}),
        Deviation(
            "foothold: eq. 15 alone",
            {"foothold": eq15, "speed": {"integral_gain": none, "station_gain": none}, "step_time": {"shortest": 1.0}},
        ),
        Deviation("foothold: eq. 15 with the integral", {"foothold": eq15}),
        Deviation("foothold: sway not an error", {"foothold": {"sway": 1.0}}),
        Deviation("foothold: k_a 0.03 s²", {"foothold": {"acceleration_gain": 0.03}}),
        Deviation("foothold: no least foot separation", {"foothold": {"separation": 1e-3}}),
        Deviation("centre of pressure: at the sole's origin", {"cop": {"gain": none}}),
        Deviation("centre of pressure: free", {"cop": {"weight": 0.0}}),
        Deviation("torque: its change not bounded", {"joints": {"torque_rate": 1e9}}),
        STANCE,
        ROLL,
        Deviation("contact: yaw moment unbounded", {"contact": {"yaw_friction": 100.0}}),
        Deviation("contact: ZMP up to the sole's edge", {"contact": {"zmp_margin": 0.0}}),
        Deviation(
            "swing foot: weight 1, gains 400 and 40",
            {"weights": {"swing_foot": 1.0}, "tracking": {"foot_stiffness": 400.0, "foot_damping": 40.0}},
        ),
        Deviation("swing foot: joints alone, no eq. 19", {"weights": {"swing_foot": 0.0}}),
        Deviation("swing foot: eqs. 10 and 11 as printed", {"printed": {"swing_via": True}}),
        INERTIAL,
        Deviation("swing foot: eq. 20 as printed", {"printed": {"swing_feedback": True}}),
        Deviation("support: eq. 7 as printed", {"printed": {"support_height": True}}),
        Deviation("support: eqs. 8 and 9 as printed", {"printed": {"support_place": True}}),
        Deviation("swing ankle: weight as the other joints", {"weights": {"swing_ankle": 0.3}}),
        Deviation("joints: PD of eq. 27 on", {"joint_gains": paper["joint_gains"]}),
        Deviation("joints: q^d = q + Δq", {"printed": {"joint_reference": True}}),
        Deviation("touchdown: by the clock at T", {"touchdown": {"earliest": 1.0, "latest": 1.0}}),
        AT_ONCE,
        Deviation("touchdown: foot stays at T's height", {"touchdown": {"descent_speed": 0.0}}),
    )


def scenarios(pushes: bool, rest: float) -> dict[str, list[Scenario]]:
    """What one row runs, by kind, after a rest, s."""
    found = {
        "fast": [Scenario(speed=(FAST, 0.0), duration=12.0, rest_before=rest, rest_after=2.0 * rest)],
        "in place": [Scenario(duration=16.0, rest_before=rest)],
    }
    if pushes:
        found["pushed"] = [
            Scenario(
                duration=5.5,
                height=PUSHED_HEIGHT,
                pushes=(Push(time=2.0, phase=phase, impulse=(IMPULSE * x, IMPULSE * y, 0.0)),),
            )
            for x, y in DIRECTIONS
            for phase in PHASES
        ]
    return found


def run_row(row: Deviation, pushes: bool, preset: str) -> dict[str, Any]:
    """Every figure of one row; None where the robot fell before it could be measured."""

    def run(scenario: Scenario) -> Summary:
        return walk_with(row, scenario, preset)

    results = {
        kind: [run(scenario) for scenario in group]
        for kind, group in scenarios(pushes, float(preset == "default")).items()
    }
    fast, still = results["fast"][0], results["in place"][0]
    pushed = results.get("pushed", [])
    falls = [summary.fall for summary in (fast, still) if summary.fall is not None]
    walking = [stage for summary in (fast, still) for stage in summary.stages if not stage.rest]
    return {
        "name": row.name,
        "numbers": row.numbers,
        "speed_error_fast": None if fast.fell else next(s.vx_error for s in fast.stages if not s.rest),
        "speed_error_in_place": None if still.fell else still.stages[-1].vx_error,
        "drift": None if still.fell else still.drift,
        "roll_deg": None if falls else max(abs(angle) for stage in walking for angle in stage.roll_deg),
        "pitch_deg": None if falls else max(abs(angle) for stage in walking for angle in stage.pitch_deg),
        "height_error": None if falls else max((stage.height_error for stage in walking), key=abs),
        "yaw_deg": None if falls else max(abs(angle) for s in (fast, still) for angle in s.yaw_deg),
        "separation": min(fast.min_foot_separation, still.min_foot_separation),
        "qp_fallbacks": fast.qp.fallbacks + still.qp.fallbacks,
        "pushes_survived": sum(not summary.fell for summary in pushed) if pushed else None,
        "pushes": len(pushed),
        "falls": [{"time": fall.time, "phase": fall.phase, "reason": fall.reason} for fall in falls],
    }


def table(rows: list[dict[str, Any]]) -> Table:
    def number(value: float | None, scale: float, digits: int, sign: str = "") -> str:
        return "–" if value is None else f"{scale * value:{sign}.{digits}f}"

    shown = Table("set back to the paper", title="one deviation at a time, BHR-B2, true state, flat ground")
    heads = ("0.4 m/s", "in place", "drift", "roll", "pitch", "height", "separation", f"{IMPULSE:g} N·s", "fell")
    units = ("mm/s", "mm/s", "cm", "±°", "±°", "mm", "cm", "survived", "after s")
    for head, unit in zip(heads, units, strict=True):
        shown.add_column(f"{head}\n{unit}", justify="right")
    for row in rows:
        shown.add_row(
            row["name"],
            number(row["speed_error_fast"], 1000.0, 1, "+"),
            number(row["speed_error_in_place"], 1000.0, 1, "+"),
            number(row["drift"], 100.0, 1),
            number(row["roll_deg"], 1.0, 2),
            number(row["pitch_deg"], 1.0, 2),
            number(row["height_error"], 1000.0, 1, "+"),
            number(row["separation"], 100.0, 1),
            "–" if row["pushes_survived"] is None else f"{row['pushes_survived']} of {row['pushes']}",
            ", ".join(f"{fall['time']:.1f}" for fall in row["falls"]) or "no",
        )
    return shown


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--preset", choices=("default", "paper"), default="default")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default="", help="rows whose name holds this word")
    parser.add_argument("--no-pushes", action="store_true")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    robot = load_robot("bhr_b2")
    known = deviations(robot) if arguments.preset == "default" else (Deviation("paper preset"), *OMITTED)
    chosen = [row for row in known if arguments.only in row.name]
    if not chosen:
        sys.exit(f"--only {arguments.only}: expected part of one of: {', '.join(row.name for row in known)}")
    Simulation(Scenario(duration=1.0), robot=robot, record=False)  # compile once, not in every process
    console, began, found = Console(stderr=True), perf_counter(), {}
    pushed = arguments.preset == "default" and not arguments.no_pushes
    progress = Progress(console=console, transient=True, disable=not console.is_terminal)
    with progress, workers(max(1, min(arguments.jobs, len(chosen)))) as crew:
        task = progress.add_task("walking", total=len(chosen))
        for row in chosen:
            crew.submit(row.name, run_row, row, pushed, arguments.preset)
        for _ in chosen:
            name, result = crew.done()
            found[name] = result
            progress.update(task, advance=1, description=f"walked: {name}")
    rows = [found[row.name] for row in chosen]
    seconds = math.ceil(perf_counter() - began)
    if arguments.json:
        print(json.dumps({"rows": rows, "seconds": seconds}, indent=2))
        return
    out = Console(width=None if sys.stdout.isatty() else 150)
    out.print(table(rows))
    for row in rows:
        for fall in row["falls"]:
            out.print(f"{row['name']}: fell at {fall['time']:.2f} s, {fall['phase']}: {fall['reason']}")
    out.print(f"{len(rows)} rows in {seconds} s")


if __name__ == "__main__":
    main()
