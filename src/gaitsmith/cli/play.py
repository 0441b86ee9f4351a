"""``gaitsmith play``: a gait file replayed in closed loop with physics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, GaitFile, OwnRobot, parse
from gaitsmith.cli.dispatch import DONE, FELL, Outcome
from gaitsmith.cli.inputs import given_steps, planned_gait
from gaitsmith.documents import About

_STEPS = 20


def _usual(name: str) -> Callable[[], str]:
    def shown() -> str:
        from gaitsmith.synthesis.proof.replay import ReplaySettings

        return f"{ReplaySettings.model_fields[name].default:g}"

    return shown


class PlayArguments(Arguments):
    """Replay a gait file in MuJoCo: joint PD, planned torque, ankle attitude stabiliser."""

    gait: GaitFile
    robot: OwnRobot = None
    steps: Annotated[
        int | None, Field(ge=1, le=10_000), About("Steps of a cyclic gait", metavar="N", absent=str(_STEPS))
    ] = None
    stiffness: Annotated[
        float | None,
        Field(ge=1.0, le=10_000.0),
        About("Of every joint's position control", metavar="N·m/rad", absent=_usual("stiffness")),
    ] = None
    damping: Annotated[
        float | None,
        Field(ge=0.01, le=1_000.0),
        About("Of every joint's position control", metavar="N·m·s/rad", absent=_usual("damping")),
    ] = None
    attitude_gain: Annotated[
        float | None,
        Field(ge=0.0, le=10.0),
        About("Angle of the ankle per angle of the torso's deviation", metavar="G", absent=_usual("attitude_gain")),
    ] = None
    friction: Annotated[
        float | None,
        Field(ge=0.01, le=5.0),
        About("Coulomb coefficient between sole and ground", metavar="MU", absent=_usual("friction")),
    ] = None
    mass_scale: Annotated[
        float | None,
        Field(ge=0.2, le=5.0),
        About("Real masses relative to planned ones", metavar="F", absent=_usual("mass_scale")),
    ] = None
    gain_scale: Annotated[
        float | None,
        Field(ge=0.05, le=5.0),
        About("Real gains relative to the given ones", metavar="F", absent=_usual("gain_scale")),
    ] = None


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
