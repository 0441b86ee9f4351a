"""``gaitsmith bench tour``: the public teleoperation test of walking, run id by run id, beside its published rows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from gaitsmith.experiments.episodes import loop_identity, run_all
from gaitsmith.experiments.options import TourOptions
from gaitsmith.experiments.push_grid import momentum_unit
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.sets import leg_length
from gaitsmith.experiments.store import Store
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation import Scenario, Summary
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.tour import LENGTH, SEGMENT, punches

_NOTHING: Mapping[str, Any] = {}
_STAND = 3.0  # s before the walk
_FORWARD, _LATERAL, _TURNING = 0.17, 0.105, 0.17  # commanded at most: of √(g leg), the same, and of √(g / leg)
_BENT, _APART = 0.77, 1.55  # height of the leg's length, and width of the card's: long steps that do not cross
_BIN, _BINS = 0.05, 7  # of mass times √(gH); the last bin has no end
_COLUMNS = ("controller", "runs", "completed\n%", "survival\ns", "position\ncm", "yaw\n°", "energy\nkJ")
# https://github.com/rhoyn/teleop-walking-benchmark, README, results in MuJoCo: learned policies.
_PUBLISHED = (
    ("gr00t_wbc, 0.66 m", "5120", "80", "85.2", "17", "8", "7.3"),
    ("decoupled_wbc, 0.66 m", "5120", "74", "83.8", "10", "7", "5.9"),
    ("homie", "5120", "55", "78.2", "17", "32", "10.3"),
    ("sonic", "512", "36", "69.2", "29", "9", "11.2"),
    ("openwbt", "512", "0", "26.5", "81", "48", "–"),
    ("rl_gym", "512", "0", "1.2", "100", "81", "–"),
)
DIFFERENCES = (
    "the published rows have an estimated state, a policy at 50 Hz, physics steps of 2 ms on a GPU, and a crane before "
    "the start; here the state is true, control runs at 1 kHz, steps are 0.5 ms, and the robot stands for 3 s",
    "a fall there is a pelvis below 0.2 m; here a torso 60° from upright, a hip below half its height, or any body but "
    "a foot on the ground, all of which come earlier",
    "arms follow their targets by the controller instead of a joint PD of the test; hands stay below the shoulders "
    "instead of below the head, and are points instead of boxes",
    "a controller names its own limits of speed there too; here turning and stepping sideways also share theirs",
    "errors here are of waypoints whose 5 s were over; there (and in brackets) also of the one that a fall cut short",
    "here a run id gives the same result to the last bit; there it does not",
)
"""What is not as in the published test."""


class _Run(NamedTuple):
    """One run: its id, when the walk began (s), what was to hit it, and what became of it."""

    id: int
    scenario: Scenario
    summary: Summary

    @property
    def survived(self) -> float:
        """Since the walk began, s."""
        return min(max(self.summary.duration - self.scenario.walk_from, 0.0), LENGTH)

    def errors(self, fallen: bool) -> list[tuple[float, float]]:
        """Of position, m, and heading, °, at every waypoint; with the one that a fall cut short, or without."""
        score = self.summary.tour
        pairs = [] if score is None else list(zip(score.position_error, score.yaw_error_deg, strict=True))
        return pairs if fallen else pairs[: int(self.survived / SEGMENT + 1e-9)]

    def hits(self) -> list[tuple[float, bool]]:
        """Horizontal impulse of every punch that landed, N·s, and whether the robot fell before the next one."""
        sizes = [math.hypot(*push.impulse[:2]) for push in self.scenario.pushes]
        landed = [size for size, began in zip(sizes, self.summary.pushes, strict=True) if began is not None]
        return [(size, self.summary.fell and k == len(landed) - 1) for k, size in enumerate(landed)]


def run_tour(
    options: TourOptions, progress: Progress = silent, fields: Mapping[str, Any] = _NOTHING, address: str = ""
) -> Result:
    """Run the test; see :mod:`gaitsmith.simulation.tour`. ``tour.json`` is written to the folder of results too.

    Args:
        address: of a Ray cluster instead of processes here.
        fields: of the scenario, put over every run's.

    Raises:
        BadInput: an option, the robot or the folder cannot be used.
    """
    loaded, first, runs = load_robot(options.robot), options.first, options.runs
    robot, preset, force = options.robot, options.preset, options.force
    gait = _gait(options, loaded)
    base = {"robot": robot, "preset": preset, "duration": _STAND + LENGTH, "rest_before": _STAND, **gait, **fields}
    scenarios = {run_id: _scenario(base, loaded, run_id, force) for run_id in range(first, first + runs)}
    store = Store(options.out)
    episodes = run_all(
        scenarios.values(), loaded, store, jobs=options.jobs, address=address, progress=progress, what="touring"
    )
    done = [
        _Run(run_id, scenario, summary)
        for run_id, scenario in scenarios.items()
        if (summary := episodes.found.get(scenario)) is not None
    ]
    document = {
        "robot": loaded.card.name,
        "preset": preset,
        "force": force,
        "gait": gait,
        "identity": loop_identity(loaded),
        **_totals(done, momentum_unit(loaded, gait["height"])),
        "interrupted": episodes.interrupted,
    }
    walked = "walked with " + ", ".join(f"{name} {value:.3g}" for name, value in gait.items())
    notes = [walked, _words_of_bins(document["punches"]), *DIFFERENCES, *episodes.notes(runs, store)]
    rows = (_row(loaded.card.name, document), *_PUBLISHED)
    result = Result(document, _COLUMNS, rows, tuple(note for note in notes if note), episodes.interrupted)
    result.write(store.path.with_name("tour.json"))
    return result


def _gait(options: TourOptions, robot: Robot) -> dict[str, float]:
    """Inputs of the gait; if none are given, legs are bent and apart, and a step's share of √(H/g) is the card's."""
    usual, limits = robot.card.gait, robot.card.gait_limits

    def within(value: float, span: tuple[float, float]) -> float:
        return round(min(max(value, span[0]), span[1]), 4)

    height = options.height or within(_BENT * leg_length(robot), limits.height)
    period = options.period or within(usual.period * math.sqrt(height / usual.height), limits.period)
    return {"height": height, "period": period, "width": options.width or within(_APART * usual.width, limits.width)}


def _scenario(base: dict[str, Any], robot: Robot, run_id: int, force: float) -> Scenario:
    """One run of the test."""
    leg, limits = leg_length(robot), robot.card.gait_limits
    gravity = -float(robot.model.opt.gravity[2])
    speed, turns = math.sqrt(gravity * leg), limits.yaw_rate or (0.0, 0.0)
    tour = {
        "id": run_id,
        "forward": min(_FORWARD * speed, limits.speed_x[1], -limits.speed_x[0]),
        "lateral": min(_LATERAL * speed, limits.speed_y[1], -limits.speed_y[0]),
        "yaw_rate": min(_TURNING * math.sqrt(gravity / leg), turns[1], -turns[0]),
    }
    given = [push.model_dump(mode="json") for push in punches(run_id, robot, _STAND, force)]
    return make_scenario({**base, "tour": tour, "pushes": given})


def _totals(done: Sequence[_Run], unit: float) -> dict[str, Any]:
    """What the runs say together; None where there is nothing to take a mean of."""
    energy = [run.summary.tour.energy for run in done if run.summary.tour is not None and not run.summary.fell]
    ended, all_of_them = ([error for run in done for error in run.errors(fallen)] for fallen in (False, True))
    hits = [(min(int(size / unit / _BIN), _BINS - 1), fell) for run in done for size, fell in run.hits()]
    return {
        "runs": len(done),
        "completed": sum(not run.summary.fell for run in done),
        "mean_survival_s": _mean([run.survived for run in done]),
        "position_error_m": _mean([position for position, _ in ended]),
        "yaw_error_deg": _mean([yaw for _, yaw in ended]),
        "with_the_fallen": {
            "position_error_m": _mean([position for position, _ in all_of_them]),
            "yaw_error_deg": _mean([yaw for _, yaw in all_of_them]),
        },
        "energy_j": _mean(energy),
        "leg_contacts": sum(run.summary.leg_contacts for run in done),
        "punches": [
            {
                "from": round(_BIN * k, 2),
                "to": round(_BIN * (k + 1), 2) if k < _BINS - 1 else None,
                "landed": sum(place == k for place, _ in hits),
                "falls": sum(fell for place, fell in hits if place == k),
            }
            for k in range(_BINS)
        ],
        "per_run": [
            {
                "id": run.id,
                "survived_s": round(run.survived, 3),
                "reason": run.summary.fall.reason if run.summary.fall is not None else "",
            }
            for run in done
        ],
    }


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _row(name: str, document: dict[str, Any]) -> tuple[str, ...]:
    """The runs in words, as the published rows have them."""
    share = document["completed"] / document["runs"] if document["runs"] else None
    force = "" if document["force"] == 1.0 else f", force × {document['force']:g}"
    there = document["with_the_fallen"]
    return (
        *(name + force, str(document["runs"]), _shown(share, 0, 100.0), _shown(document["mean_survival_s"], 1)),
        *(_both(document, there, "position_error_m", 100.0), _both(document, there, "yaw_error_deg", 1.0)),
        _shown(document["energy_j"], 1, 1e-3),
    )


def _shown(value: float | None, digits: int, scale: float = 1.0) -> str:
    return "–" if value is None else f"{scale * value:.{digits}f}"


def _both(ended: dict[str, Any], there: dict[str, Any], name: str, scale: float) -> str:
    """A mean over the waypoints whose time was over and, if another one, as the published rows count."""
    first, second = (_shown(of[name], 0, scale) for of in (ended, there))
    return first if first == second else f"{first} ({second})"


def _words_of_bins(bins: Sequence[dict[str, Any]]) -> str:
    """Falls after punches, by their strength; empty without punches."""
    landed, falls = sum(entry["landed"] for entry in bins), sum(entry["falls"] for entry in bins)
    if not landed:
        return ""
    each = ", ".join(
        (f"{entry['from']:g} to {entry['to']:g}" if entry["to"] else f"over {entry['from']:g}")
        + f": {entry['falls']} of {entry['landed']}"
        for entry in bins
    )
    return f"falls per punch {falls} of {landed} ({falls / landed:.1%}); by horizontal impulse over m√(gH): {each}"
