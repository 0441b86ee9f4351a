"""The battery: every trial with its scenario as data and the limits that it is judged by."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from gaitsmith.experiments.limits import Limit
from gaitsmith.simulation.scenario import Scenario, load_scenario, make_scenario

SPEED = 0.2  # m/s, while the gait's other parameters change
HELD = 20.0  # s after every change
_FIRST = 5.0  # s, when the first change comes
_STAIRS = (0.66, 0.62, 0.58, 0.54, 0.51, 0.48, 0.51, 0.54, 0.58, 0.62, 0.66, 0.70)  # m
_STEADY = (Limit("height_error", 0.005),)


@dataclass(frozen=True)
class Trial:
    """One trial; without limits it is judged by falls alone.

    Attributes:
        name: as ``--only`` takes it.
        scenario: fields of :class:`gaitsmith.simulation.Scenario`.
        limits: to keep in every episode.
        reported: quantities shown without a limit.
        seeds: one episode each.
        judged: False to report only.
    """

    name: str
    scenario: dict[str, Any] = field(hash=False)
    limits: tuple[Limit, ...] = ()
    reported: tuple[str, ...] = ()
    seeds: tuple[int, ...] = (0,)
    judged: bool = True

    def scenarios(self, robot: str, preset: str) -> list[Scenario]:
        """One scenario for each seed; a preset that the trial names itself comes first."""
        base = {"robot": robot, "preset": preset, **self.scenario}
        return [make_scenario({**base, "seed": seed}) for seed in self.seeds]

    def target(self) -> str:
        """What is asked for, in words."""
        if not self.judged:
            return "report"
        return "; ".join(["no fall", *(limit.target() for limit in self.limits)])


def _walk(seconds: float, speed: Sequence[float], **fields: Any) -> dict[str, Any]:
    """A second of standing, then a walk."""
    return {"duration": 1.0 + seconds, "rest_before": 1.0, "speed": list(speed), **fields}


def _held(name: str, values: Iterable[float], **fields: Any) -> dict[str, Any]:
    """Walking slowly, one parameter of the gait takes each value in turn and keeps it."""
    changes = [{"time": _FIRST + k * HELD, name: value} for k, value in enumerate(values)]
    return {"duration": _FIRST + len(changes) * HELD, "speed": [SPEED, 0.0], "changes": changes, **fields}


def _figure5(**fields: Any) -> dict[str, Any]:
    """The paper's speed profile."""
    return {**load_scenario("figure5").model_dump(mode="json", exclude_unset=True), **fields}


def battery_trials() -> tuple[Trial, ...]:
    """All trials in the order of the table."""
    steps = [{"time": 6.0, "speed": 0.7}, {"time": 14.0, "speed": 0.0}]
    estimated = {"state": "estimated", "joint_friction": 3.0, "torque_delay": 0.002}
    return (
        Trial(
            "figure5",
            _figure5(),
            (
                Limit("speed_error", 0.003),
                Limit("roll", 0.4),
                Limit("pitch", 1.0),
                Limit("separation", 0.07, least=True),
                Limit("leg_contacts", 0),
            ),
            ("height_error", "lateral_error", "yaw"),
        ),
        Trial("speed_0.7", _walk(60.0, (0.7, 0.0)), reported=("speed_error", "yaw")),
        Trial("speed_-0.4", _walk(20.0, (-0.4, 0.0)), reported=("speed_error",)),
        Trial("speed_steps", _walk(21.0, (0.0, 0.0), changes=steps), reported=("speed_error",)),
        Trial("in_place", _walk(60.0, (0.0, 0.0)), (Limit("drift", 0.1),), ("yaw",)),
        *(
            Trial(f"lateral_{vy:g}", _walk(20.0, (0.0, vy)), (Limit("lateral_error", 0.010),), ("speed_error",))
            for vy in (0.1, 0.2)
        ),
        Trial("height_stairs", _held("height", _STAIRS, height=0.70), _STEADY),
        Trial("height_jump", _held("height", (0.48, 0.70), height=0.70), _STEADY),
        *(Trial(f"lift_{lift:g}", _held("lift", (lift,)), _STEADY) for lift in (0.03, 0.05, 0.10, 0.15)),
        *(
            Trial(f"period_{period:g}", _held("period", (period,)), _STEADY)
            for period in (0.25, 0.30, 0.35, 0.45, 0.50, 0.55, 0.60)
        ),
        *(Trial(f"alpha_{alpha:g}", _held("alpha", (alpha,)), _STEADY) for alpha in (0.3, 0.4, 0.5, 0.6)),
        Trial("alpha_0.7", _held("alpha", (0.7,)), reported=("height_error",), judged=False),
        *(
            Trial(f"slope_{angle:+d}", _walk(20.0, (0.3, 0.0), terrain=f"slope:{angle}"), reported=("saturated",))
            for angle in (8, -8)
        ),
        Trial("boxes", _walk(20.0, (0.3, 0.0), terrain="boxes:0.06", lift=0.12), seeds=tuple(range(5))),
        Trial(
            "figure5_estimated",
            _figure5(**estimated),
            (Limit("speed_error", 0.015),),
            ("roll", "pitch"),
            seeds=tuple(range(10)),
        ),
        *(
            Trial(f"paper_{speed:g}", _walk(20.0, (speed, 0.0), preset="paper"), reported=("speed_bias", "pitch"))
            for speed in (0.0, 0.4)
        ),
    )
