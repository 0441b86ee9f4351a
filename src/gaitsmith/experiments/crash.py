"""``gaitsmith bench crash``: what fells a controller, in the robot's own units, on one sheet."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import loop_identity, run_all, why_unfit
from gaitsmith.experiments.faults import run_faults
from gaitsmith.experiments.largest import Search, search_largest
from gaitsmith.experiments.options import CrashOptions, FaultOptions, TourOptions
from gaitsmith.experiments.push_grid import GridOutcome, PushGrid, momentum_unit, recovery_time, survived
from gaitsmith.experiments.random_walks import run_walks
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.sets import walking
from gaitsmith.experiments.store import Store
from gaitsmith.experiments.tour import run_tour
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation import Scenario
from gaitsmith.simulation.remote import identity_of
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.step_policy import OnnxPolicy
from gaitsmith.work.workers import address_of

FILE = "crash.json"
SOON = 11.2  # √(H/g), within which a push is to be recovered from; 3 s at H = 0.7 m
_SPEED = 0.115  # √(gH), on every ground
_FINE = 0.02  # m√(gH), to which the largest push is searched
_BEFORE, _AHEAD = 0.6, 6.0  # walked before a slope begins, m, and after that, H
_BOX_SEEDS = 3
PARTS = ("pushes", "weakest", "episodes", "faults", "terrain")


class _Crash:
    """One crash test as it goes: every part fills its entry of the document, and says whether Ctrl-C cut it short."""

    def __init__(self, options: CrashOptions, progress: Progress) -> None:
        self.options, self.progress = options, progress
        self.address = address_of(options.engine, options.address)
        self.robot = load_robot(options.robot)
        if options.preset not in self.robot.card.presets:
            raise BadInput("--preset", options.preset, "one of " + ", ".join(sorted(self.robot.card.presets)))
        self.controller, fields = tested(options, self.robot)
        self.fields = {"robot": options.robot, "preset": options.preset, **fields}
        self.store = Store(options.out)
        self.unit = momentum_unit(self.robot, self.robot.card.gait.height)
        walk = walking(self.fields, self.robot)
        size = round(options.strength * self.unit, 3)
        self.grid = PushGrid(size, walk, directions=options.directions, phases=options.phases)
        self.gravity = -float(self.robot.model.opt.gravity[2])
        self.found: dict[str, Any] = dict.fromkeys(
            ("pushes", "episodes", "faults", "weakest_push", "terrain", "tour", "push_map")
        )
        self.notes: list[str] = []

    @property
    def _shared(self) -> dict[str, Any]:
        return {"jobs": self.options.jobs, "progress": self.progress, "address": self.address}

    def pushes(self) -> bool:
        """The map."""
        scenarios = {cell: self.grid.scenario(cell) for cell in self.grid.cells}
        episodes = run_all(scenarios.values(), self.robot, self.store, what="pushing", **self._shared)
        found = {cell: s for cell, scenario in scenarios.items() if (s := episodes.found.get(scenario)) is not None}
        outcome, soon = GridOutcome(self.grid, found), SOON * math.sqrt(self.robot.card.gait.height / self.gravity)
        times = [recovery_time(found[cell]) for cell in outcome.survivors]
        self.found["pushes"] = {
            "strength": self.options.strength,
            "impulse": self.grid.impulse,
            "cells": len(found),
            "survived": len(outcome.survivors),
            "recovered": sum(time is not None and time <= soon for time in times),
            "within_s": round(soon, 3),
            "largest": None,
        }
        self.found["push_map"] = outcome.document()
        unpushed = sum(summary.pushes[:1] in ((), (None,)) for summary in found.values())
        if unpushed:
            self.notes.append(f"{unpushed} pushes never began: it had fallen before, or its controller tells no steps")
        return episodes.interrupted

    def weakest(self) -> bool:
        """The largest push in every direction that is survived at all phases, and the weakest that is not."""
        resolution = round(_FINE * self.unit, 6)
        (search,), interrupted = search_largest(
            [self.grid], self.robot, self.store, self.options.jobs, self.progress, resolution, self.address
        )
        if interrupted:
            return True
        pushes = self.found["pushes"] or {}
        pushes["largest"] = [
            {"direction": self.grid.degrees(i), "impulse": low, "strength": round(low / self.unit, 4)}
            for i, low in enumerate(search.low)
            if low is not None
        ]
        self.found["pushes"] = pushes
        felled = [(high, i) for i, high in enumerate(search.high) if high is not None]
        if felled:
            self.found["weakest_push"] = self._weakest(search, *min(felled))
        return False

    def _weakest(self, search: Search, impulse: float, direction: int) -> dict[str, Any]:
        """One push that fells: of the phases at which it does, the one after which the robot fell soonest."""
        cells = [cell for cell in self.grid.cells if cell.direction == direction]
        scenarios = {cell: search.grid.scenario(cell, impulse) for cell in cells}
        episodes = run_all(scenarios.values(), self.robot, self.store, what="weakest push", **self._shared)
        fell = {cell: s for cell, scenario in scenarios.items() if not survived(s := episodes.found[scenario])}
        cell = min(fell, key=lambda one: fell[one].duration)
        return {
            "impulse": impulse,
            "strength": round(impulse / self.unit, 4),
            "direction": self.grid.degrees(direction),
            "phase": cell.phase / self.grid.phases,
        }

    def episodes(self) -> bool:
        """Random walks."""
        options = self.options
        walks = run_walks(
            self.robot,
            self.store,
            fields=self.fields,
            runs=options.runs,
            first=options.seed,
            target=options.target,
            **self._shared,
        )
        self.found["episodes"] = walks.document()
        return walks.interrupted

    def faults(self) -> bool:
        """Every component that fails in every way."""
        options = self.options
        same = options.model_dump(include={"robot", "preset", "instants", "duration", "jobs", "out"})
        result = run_faults(FaultOptions(**same), self.progress, self._walker, self.address)
        self.found["faults"] = result.document["faults"]
        return result.interrupted

    def terrain(self) -> bool:
        """Ground that is not level."""
        grounds = self._grounds()
        unfit = {name: why for name, scenarios in grounds.items() if (why := why_unfit(scenarios, self.robot))}
        self.notes += [f"{name}: skipped, {why}" for name, why in unfit.items()]
        fit = {name: scenarios for name, scenarios in grounds.items() if name not in unfit}
        wanted = [scenario for scenarios in fit.values() for scenario in scenarios]
        episodes = run_all(wanted, self.robot, self.store, what="other ground", **self._shared)
        entries = []
        for name, scenarios in fit.items():
            own = [summary for one in scenarios if (summary := episodes.found.get(one)) is not None]
            entries.append({"what": name, "survived": sum(not summary.fell for summary in own), "of": len(own)})
        self.found["terrain"] = entries
        return episodes.interrupted

    def tour(self) -> bool:
        """The public teleoperation test."""
        same = self.options.model_dump(include={"robot", "preset", "jobs", "out"})
        result = run_tour(TourOptions(runs=self.options.tour, **same), self.progress, self._walker, self.address)
        self.found["tour"] = result.document
        return result.interrupted

    @property
    def _walker(self) -> dict[str, Any]:
        """What the controller adds to a scenario that has its robot and preset."""
        return {name: value for name, value in self.fields.items() if name not in ("robot", "preset")}

    def _grounds(self) -> dict[str, list[Scenario]]:
        """Scenarios by the ground's name."""
        height, limits = self.robot.card.gait.height, self.robot.card.gait_limits.speed_x
        speed = round(min(_SPEED * math.sqrt(self.gravity * height), limits[1]), 4)
        length = round(2.0 + (_BEFORE + _AHEAD * height) / max(speed, 1e-3), 3)
        tread, edge = round(0.43 * height, 4), round(max(0.43 * height, 0.3), 4)
        step = round(0.057 * height, 4)

        def made(terrain: str, **more: Any) -> Scenario:
            walk = {"speed": [speed, 0.0], "duration": length, "terrain": terrain}
            return make_scenario({**self.fields, **walk, **more})

        grounds = {f"slope {angle:+d}°": [made(f"slope:{angle}")] for angle in (8, -8, 12, -12)}
        grounds |= {f"cross slope {angle:+d}°": [made(f"cross:{angle}")] for angle in (4, -4, 8, -8)}
        for share in (0.057, 0.114):
            boxes = [made(f"boxes:{share * height:.4f}", seed=seed) for seed in range(_BOX_SEEDS)]
            grounds[f"boxes up to {share} H"] = boxes
        grounds |= {
            f"{way} five stairs of 0.057 H": [made(f"stairs:{sign * step},{tread},{edge},5")]
            for way, sign in (("up", 1), ("down", -1))
        }
        grounds["1.4 H of ice, friction 0.15"] = [made(f"ice:0.15,{edge},{round(1.4 * height, 3)}")]
        return grounds


def tested(options: CrashOptions, robot: Robot) -> tuple[str, Mapping[str, Any]]:
    """Name of the controller that is tested, and the scenario fields that it needs.

    Raises:
        BadInput: no such controller, or a policy for other joints, numbers or ranges.
    """
    kind, _, path = options.controller.partition(":")
    if options.controller == "ours":
        return "the package's own controller", {}
    if kind == "onnx" and path:
        OnnxPolicy(path, robot)
        return f"the package's own controller with the policy {Path(path).name}", {"policy": str(Path(path).resolve())}
    if kind == "socket" and path:
        return identity_of(options.controller), {"controller": options.controller}
    raise BadInput("--controller", options.controller, "ours, onnx:FILE or socket:PORT")


def run_crash(options: CrashOptions, progress: Progress = silent) -> Result:
    """Run the test, part by part; ``crash.json`` is written to the folder of results too.

    Raises:
        BadInput: an option, the robot, the controller or the folder cannot be used.
    """
    crash, interrupted = _Crash(options, progress), False
    asked = options.only or PARTS
    for part in (*[part for part in PARTS if part in asked], *(["tour"] if options.tour else [])):
        interrupted = getattr(crash, part)()
        if interrupted:
            crash.notes.append(f"interrupted during {part}; the same command goes on from there")
            break
    document = {
        "robot": crash.robot.card.name,
        "preset": options.preset,
        "controller": crash.controller,
        "asked": options.model_dump(
            mode="json", include=set(CrashOptions.model_fields) - {"jobs", "engine", "address", "out"}
        ),
        "identity": loop_identity(crash.robot),
        "momentum_unit": round(crash.unit, 4),
        **crash.found,
        "notes": crash.notes,
        "interrupted": interrupted,
    }
    rows = tuple(rows_of(document))
    result = Result(document, ("part", "outcome"), rows, tuple(crash.notes), interrupted)
    result.write(crash.store.path.with_name(FILE))
    return result


def rows_of(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The document's figures in words, a row each."""
    rows = []
    if pushes := document["pushes"]:
        if "cells" in pushes:
            words = f"{pushes['survived']} of {pushes['cells']} survived"
            words += f", {pushes['recovered']} recovered within {pushes['within_s']:.2g} s, legs never touching"
            rows.append((f"pushes of {pushes['strength']:g} m√(gH), {pushes['impulse']:.3g} N·s", words))
        if pushes["largest"]:
            least = min(pushes["largest"], key=lambda entry: entry["impulse"])
            words = f"{least['strength']:.3g} m√(gH), {least['impulse']:.3g} N·s, at {least['direction']:g}°"
            rows.append(("survived in every direction at every phase", words))
    if weakest := document["weakest_push"]:
        words = f"{weakest['strength']:.3g} m√(gH), {weakest['impulse']:.3g} N·s, at {weakest['direction']:g}°"
        rows.append(("weakest push that fells it", f"{words}, phase {weakest['phase']:.3g}"))
    if episodes := document["episodes"]:
        low, high = episodes["interval"]
        words = f"{episodes['survived']} of {episodes['runs']} stand; share {low:.1%} to {high:.1%} (95 %)"
        rows.append(("random walks", words))
    if faults := document["faults"]:
        stood, of = (sum(entry[name] for entry in faults) for name in ("survived", "of"))
        rows.append(("faults", f"{stood} of {of} stood"))
    if terrain := document["terrain"]:
        stood, of = (sum(entry[name] for entry in terrain) for name in ("survived", "of"))
        lost = ", ".join(entry["what"] for entry in terrain if entry["survived"] < entry["of"])
        rows.append(("other ground", f"{stood} of {of} stood" + (f"; fell on {lost}" if lost else "")))
    if tour := document["tour"]:
        rows.append(("public teleoperation test", f"{tour['completed']} of {tour['runs']} completed"))
    return rows
