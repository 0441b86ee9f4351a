"""``gaitsmith play``: a gait file replayed in closed loop with physics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from gaitsmith.cli.arguments import Positional, integer, number, parse, text
from gaitsmith.cli.dispatch import DONE, FELL, Outcome
from gaitsmith.errors import BadInput

_RANGES = {
    "steps": (1, 10_000),
    "friction": (0.01, 5.0),
    "mass_scale": (0.2, 5.0),
    "gain_scale": (0.05, 5.0),
    "stiffness": (1.0, 10_000.0),
    "damping": (0.01, 1_000.0),
    "attitude_gain": (0.0, 10.0),
}


@dataclass(frozen=True)
class PlayArguments:
    """Replay a gait file in MuJoCo: joint PD, planned torque, ankle attitude stabiliser."""

    gait: Annotated[str, Positional, text("GAIT", "GAIT")]
    """Gait file."""
    robot: Annotated[str | None, text("--robot", "NAME_OR_PATH")] = None
    """The robot it was planned for, if it is not one of the package."""
    steps: Annotated[int, integer("--steps", "N", 1)] = 20
    """Steps of a cyclic gait."""
    stiffness: Annotated[float, number("--stiffness", "N·m/rad")] = 300.0
    """Of every joint's position control."""
    damping: Annotated[float, number("--damping", "N·m·s/rad")] = 6.0
    """Of every joint's position control."""
    attitude_gain: Annotated[float, number("--attitude-gain", "G")] = 0.5
    """Angle of the ankle per angle of the torso's deviation."""
    friction: Annotated[float, number("--friction", "MU")] = 0.8
    """Coulomb coefficient between sole and ground."""
    mass_scale: Annotated[float, number("--mass-scale", "F")] = 1.0
    """Real masses relative to planned ones."""
    gain_scale: Annotated[float, number("--gain-scale", "F")] = 1.0
    """Real gains relative to the given ones."""
    json: bool = False
    """Print one JSON document instead of text."""


def play(words: list[str], program: str) -> Outcome:
    """Run the command.

    Raises:
        BadInput: the command line, the file or the robot cannot be used.
    """
    arguments = parse(PlayArguments, words, program)
    for name, (low, high) in _RANGES.items():
        value = getattr(arguments, name)
        if not low <= value <= high:
            raise BadInput("--" + name.replace("_", "-"), value, f"{low:g} to {high:g}")
    from gaitsmith.synthesis import load_robot_of, read_gait
    from gaitsmith.synthesis.replay import ReplaySettings, replay

    gait, _ = read_gait(arguments.gait)
    robot = load_robot_of(gait, arguments.robot)
    settings = ReplaySettings(**{name: getattr(arguments, name) for name in _RANGES if name != "steps"})
    result = replay(gait, robot, settings, arguments.steps)
    document: dict[str, Any] = {"motion": gait.motion.name, "robot": robot.card.name, **result.as_dict()}

    def show() -> None:
        from gaitsmith.cli.printing import Printer

        console = Printer()
        if result.stood:
            console.print(f"stood for {result.duration:.2f} s")
        elif result.fall is not None:
            console.print(f"fell at {result.fall['time']:.2f} s: {result.fall['reason']}")
        console.print(f"distance {result.distance:.3f} of {result.planned_distance:.3f} m, drift {result.drift:.3f} m")
        tilt = result.tilt_deg
        console.print(f"largest deviation of the torso: roll {tilt['roll']:.2f}°, pitch {tilt['pitch']:.2f}°")
        console.print(f"real ZMP: {result.zmp_error_mm:.1f} mm from the plan, margin {result.zmp_margin_mm:.1f} mm")
        console.print(f"torque clipped at {100.0 * result.torque_saturated:.2f} % of the ticks")
        if result.ball is not None:
            console.print(f"ball: {result.ball['speed']:.2f} m/s, {result.ball['travel']:.2f} m")

    return Outcome(DONE if result.stood else FELL, document, show)
