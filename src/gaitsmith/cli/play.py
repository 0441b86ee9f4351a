"""``gaitsmith play``: a gait file replayed in closed loop with physics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

from gaitsmith.cli.arguments import Positional, integer, number, parse, text
from gaitsmith.cli.dispatch import DONE, FELL, Outcome
from gaitsmith.cli.inputs import given_steps, planned_gait

_STEPS = 20


def _usual(name: str) -> Callable[[], object]:
    def shown() -> object:
        from gaitsmith.synthesis.proof.replay import ReplaySettings

        return ReplaySettings.model_fields[name].default

    return shown


@dataclass(frozen=True)
class PlayArguments:
    """Replay a gait file in MuJoCo: joint PD, planned torque, ankle attitude stabiliser."""

    gait: Annotated[str, Positional, text("GAIT", "GAIT")]
    """Gait file."""
    robot: Annotated[str | None, text("--robot", "NAME_OR_PATH", absent="the one it names")] = None
    """The robot it was planned for, if it is not one of the package."""
    steps: Annotated[int | None, integer("--steps", "N", 1, 10_000, absent=str(_STEPS))] = None
    """Steps of a cyclic gait."""
    stiffness: Annotated[float | None, number("--stiffness", "N·m/rad", _usual("stiffness"), (1.0, 10_000.0))] = None
    """Of every joint's position control."""
    damping: Annotated[float | None, number("--damping", "N·m·s/rad", _usual("damping"), (0.01, 1_000.0))] = None
    """Of every joint's position control."""
    attitude_gain: Annotated[float | None, number("--attitude-gain", "G", _usual("attitude_gain"), (0.0, 10.0))] = None
    """Angle of the ankle per angle of the torso's deviation."""
    friction: Annotated[float | None, number("--friction", "MU", _usual("friction"), (0.01, 5.0))] = None
    """Coulomb coefficient between sole and ground."""
    mass_scale: Annotated[float | None, number("--mass-scale", "F", _usual("mass_scale"), (0.2, 5.0))] = None
    """Real masses relative to planned ones."""
    gain_scale: Annotated[float | None, number("--gain-scale", "F", _usual("gain_scale"), (0.05, 5.0))] = None
    """Real gains relative to the given ones."""
    json: bool = False
    """Print one JSON document instead of text."""


def play(words: list[str], program: str) -> Outcome:
    """Run the command.

    Raises:
        BadInput: the command line, the file or the robot cannot be used.
    """
    arguments = parse(PlayArguments, words, program)
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis.proof.replay import ReplaySettings, replay

    gait, robot, _ = planned_gait(arguments.gait, arguments.robot)
    steps = given_steps(arguments.steps, gait, _STEPS)
    given = {name: getattr(arguments, name) for name in ReplaySettings.model_fields if hasattr(arguments, name)}
    settings = ReplaySettings(**{name: value for name, value in given.items() if value is not None})
    with Display("preparing") as display:
        tell = lambda now, end: display.show("replaying", f"{now:.1f} of {end:.1f} s", now, end)  # noqa: E731
        result = replay(gait, robot, settings, steps, tell)
    document: dict[str, Any] = {"motion": gait.motion.name, "robot": robot.card.name, **result.as_dict()}

    def show() -> None:
        from gaitsmith.cli.printing import Printer, figure

        console = Printer()
        if result.stood:
            console.print(f"stood for {result.duration:.2f} s")
        elif result.fall is not None:
            console.print(f"fell at {result.fall['time']:.2f} s: {result.fall['reason']}")
        console.print(f"distance {result.distance:.3f} of {result.planned_distance:.3f} m, drift {result.drift:.3f} m")
        tilt = result.tilt_deg
        console.print(f"largest deviation of the torso: roll {tilt['roll']:.2f}°, pitch {tilt['pitch']:.2f}°")
        error, margin = figure(result.zmp_error_mm, ".1f"), figure(result.zmp_margin_mm, ".1f")
        console.print(f"real ZMP: {error} mm from the plan, margin {margin} mm")
        console.print(f"torque clipped at {100.0 * result.torque_saturated:.2f} % of the ticks")
        if result.ball is not None:
            console.print(f"ball: {result.ball['speed']:.2f} m/s, {result.ball['travel']:.2f} m")

    return Outcome(DONE if result.stood else FELL, document, show)
