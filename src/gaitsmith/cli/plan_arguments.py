"""The command line of ``gaitsmith plan``: which flags there are, to what each applies, and what they ask for."""

from __future__ import annotations

import math
import os
from typing import Annotated, Any, Literal

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, Positional, flag
from gaitsmith.documents import About
from gaitsmith.errors import BadInput
from gaitsmith.experiments.options import RobotName
from gaitsmith.synthesis.motions.parameters import JumpParameters, KickParameters, StepParameters
from gaitsmith.synthesis.motions.settings import LEG, Bounds, Settings
from gaitsmith.synthesis.requests.asked import KICK_FRICTION, KICK_SPEEDS, MOST_CYCLES, RANGES, Request, stride

CLAIMS, SWEEP, FILE = "--claims", "sweep", "a motion file"
_BOUNDS, _SETTINGS = Bounds.model_fields, Settings.model_fields
_WALKS = ("cyclic", "start", "stop", "walk")
_NAMED = (*_WALKS, "kick", "stairs", "turn", "jump")
_STEPS = (3, 60)  # of stairs or a turn
_ANGLES = (1.0, 40.0)  # degrees a step
_APPLIES: dict[str, tuple[str, ...]] = {
    "speed": (*_WALKS, "kick"),
    **dict.fromkeys(("order", "zmp_margin", "friction", "max_iterations"), _NAMED),
    "step_length": (*_WALKS, "turn"),
    **dict.fromkeys(("period", "step_height", "double_support"), (*_WALKS, "stairs", "turn")),
    **dict.fromkeys(("rise", "tread"), ("stairs",)),
    "steps": ("stairs", "turn"),
    "slope": _WALKS,
    "angle": ("turn",),
    "jump_height": ("jump",),
    "cycles": ("walk",),
    "free_times": _WALKS,
    "jobs": (SWEEP,),
    **dict.fromkeys(("ball", "kick_height", "x_max"), ("kick",)),
    **dict.fromkeys(("out", "figures", "free"), (*_NAMED, FILE)),
}


Reach = Annotated[float, Field(ge=-1.0, le=1.0)]
_LENGTH, _PERIOD = stride(None, None, None)
_KICK = f", for a kick {KickParameters.speed:g}, from {KICK_SPEEDS[0]:g} to {KICK_SPEEDS[1]:g}"


def _usual(value: float, flag: str) -> str:
    low, high = RANGES[flag]
    return f"{value:g}, from {low:g} to {high:g}"


class PlanArguments(Arguments):
    """Plan a motion: cyclic, start, stop, walk, kick, stairs, turn, jump, sweep, or a motion file (TOML).

    Of speed, step length and period any two decide the third; one alone follows the paper's two gaits. Lengths and
    times that are defaults hold for hips 0.39 m high; a robot of another size gets them in proportion. Where a speed
    given alone has no gait, shorter steps at that speed are tried.
    """

    motion: Annotated[
        str | None,
        Positional(
            "cyclic, start, stop, walk, kick, stairs, turn, jump, sweep, or the path of a motion file",
            metavar="MOTION",
            absent="cyclic",
        ),
    ] = None
    robot: RobotName = "thbip_ii"
    speed: Annotated[
        float | None,
        About(
            "Walking speed, m/s; for a kick the ankle's speed at the ball",
            metavar="V",
            absent=_usual(_LENGTH / _PERIOD, "--speed") + _KICK,
        ),
    ] = None
    step_length: Annotated[
        float | None,
        About("From one foothold to the next", "m", "M", absent=_usual(_LENGTH, "--step-length") + "; 0 of a turn"),
    ] = None
    period: Annotated[float | None, About("Of one step", "s", "S", absent=_usual(_PERIOD, "--period"))] = None
    step_height: Annotated[
        float | None,
        Field(ge=0.005, le=0.3),
        About("Height of the swing ankle above its height on the ground", "m", "M", StepParameters.height),
    ] = None
    double_support: Annotated[
        float | None,
        Field(ge=0.05, le=0.8),
        About("Share of the period with both feet on the ground", "", "SHARE", StepParameters.double_support),
    ] = None
    free: Annotated[
        tuple[str, ...],
        About("A joint outside the legs that moves too; the others stay at their home angles", metavar="JOINT"),
    ] = ()
    ball: Annotated[
        tuple[Reach, Reach] | None,
        About(
            "Where a kick's ankle meets the ball: ahead of and left of the middle between the soles",
            "m",
            "X Y",
            " ".join(f"{value:g}" for value in KickParameters.ball),
        ),
    ] = None
    kick_height: Annotated[
        float | None,
        Field(ge=0.005, le=0.3),
        About("Height of a kick's raised ankle above its height on the ground", "m", "M", KickParameters.height),
    ] = None
    x_max: Annotated[Reach | None, About("How far ahead a kick's ankle swings", "m", "M", KickParameters.reach)] = None
    jump_height: Annotated[
        float | None,
        Field(ge=0.005, le=0.3),
        About("Height of a jump's soles above the ground", "m", "M", JumpParameters.height),
    ] = None
    rise: Annotated[
        float | None,
        Field(ge=-0.5, le=0.5),
        About("Of stairs: how much higher every tread is; negative: lower", "m", "M", "0.05"),
    ] = None
    tread: Annotated[
        float | None, Field(gt=0.0, le=2.0), About("Of stairs: from one edge to the next", "m", "M", "0.2")
    ] = None
    steps: Annotated[
        int | None,
        Field(ge=_STEPS[0], le=_STEPS[1]),
        About("Of stairs: how many; of a turn: how many that turn, an odd number", metavar="N", absent="5"),
    ] = None
    angle: Annotated[
        float | None,
        About("Of a turn: heading of every step against the one before, to the left", "degrees", "DEG", "15"),
    ] = None
    slope: Annotated[
        float | None,
        Field(ge=-25.0, le=25.0),
        About("Of the ground: how steeply it rises ahead; negative: falls", "degrees", "DEG", "0"),
    ] = None
    order: Annotated[
        Literal[4, 5] | None,
        About("Degree of the joint splines: 4 as in the paper, or 5", absent=_SETTINGS["order"].default),
    ] = None
    free_times: Annotated[
        bool, About("Choose phase times and foot pitches, besides the torques, for the least J (about ten seconds)")
    ] = False
    cycles: Annotated[
        int | None,
        About("Steps of the cyclic gait in a walk", metavar="N", absent=f"{Request.cycles}, from 0 to {MOST_CYCLES}"),
    ] = None
    zmp_margin: Annotated[
        float | None,
        *_BOUNDS["zmp_margin"].metadata,
        About("Distance of the ZMP from the support sole's edge", "m", "M", _BOUNDS["zmp_margin"].default),
    ] = None
    friction: Annotated[
        float | None,
        *_BOUNDS["friction"].metadata,
        About("Coulomb coefficient", "", "MU", f"{_BOUNDS['friction'].default:g}, for a kick {KICK_FRICTION:g}"),
    ] = None
    max_iterations: Annotated[
        int | None,
        *_SETTINGS["max_iterations"].metadata,
        About(
            "Of all solves of a motion; spent, they leave it undecided",
            metavar="N",
            absent=_SETTINGS["max_iterations"].default,
        ),
    ] = None
    jobs: Annotated[int | None, Field(ge=1, le=256), About("Processes of a sweep", metavar="N", absent="1")] = None
    out: Annotated[str | None, About("Gait file to write", metavar="FILE", absent="none")] = None
    figures: Annotated[str | None, About("New folder for figures (PNG)", metavar="DIR", absent="none")] = None
    claims: Annotated[bool, About("Plan the paper's two cyclic gaits and print its claims beside our figures")] = False


def task_of(arguments: PlanArguments) -> str:
    """What is to be done: a kind of motion, :data:`SWEEP`, :data:`CLAIMS` or :data:`FILE`.

    Raises:
        BadInput: an unknown motion, or a flag that means nothing for this task.
    """
    if arguments.claims and arguments.motion is not None:
        raise BadInput("MOTION", arguments.motion, "nothing with --claims", "it plans the paper's two cyclic gaits")
    task = CLAIMS if arguments.claims else arguments.motion or "cyclic"
    if task not in (*_NAMED, SWEEP, CLAIMS):
        if not os.path.isfile(task):
            raise BadInput("MOTION", task, f"{', '.join(_NAMED)}, {SWEEP}, or a motion file (TOML)")
        task = FILE
    for name, tasks in _APPLIES.items():
        value = getattr(arguments, name)
        if value not in (None, (), False) and task not in tasks:
            raise BadInput(flag(name), value, f"nothing with {task}", f"for {', '.join(tasks)} only")
    return task


def request_from(arguments: PlanArguments, task: str, leg: float = LEG, usual: float | None = None) -> Request | None:
    """The request that the flags describe, for hips ``leg`` m high; None for a motion file.

    ``usual``: period of a robot's steps, s, where it has one.

    Raises:
        BadInput: naming the flag.
    """
    if task == FILE:
        return None
    friction = KICK_FRICTION if task == "kick" and arguments.friction is None else arguments.friction
    bounds = Bounds(**_given(zmp_margin=arguments.zmp_margin, friction=friction))
    settings = Settings(bounds=bounds, **_given(order=arguments.order, max_iterations=arguments.max_iterations))
    if task == "kick":
        if arguments.speed is not None and not KICK_SPEEDS[0] <= arguments.speed <= KICK_SPEEDS[1]:
            raise BadInput("--speed", arguments.speed, f"{KICK_SPEEDS[0]:g} to {KICK_SPEEDS[1]:g} for a kick")
        given = _given(speed=arguments.speed, ball=arguments.ball, height=arguments.kick_height, reach=arguments.x_max)
        return Request("kick", kick=KickParameters(**given), settings=settings)
    if task == "jump":
        size, usual_jump = leg / LEG, JumpParameters()
        height = size * usual_jump.height if arguments.jump_height is None else arguments.jump_height
        push, land = usual_jump.durations
        durations = (push * size**0.5, land * size**0.5)
        return Request("jump", jump=JumpParameters(height, durations), settings=settings)
    if task == "stairs":
        return _stairs(arguments, settings, leg)
    if task == "turn":
        return _turn(arguments, settings, leg)
    length, period = stride(arguments.speed, arguments.step_length, arguments.period, leg, usual)
    shape = _given(height=arguments.step_height, double_support=arguments.double_support)
    shape |= {} if arguments.slope is None else {"slope": math.radians(arguments.slope)}
    step = StepParameters.sized(leg, length, period, **shape)
    faster = arguments.step_length is None and arguments.period is None
    more = _given(cycles=arguments.cycles, free_times=arguments.free_times)
    return Request(task, step=step, settings=settings, faster=faster, **more)  # type: ignore[arg-type]


def _stairs(arguments: PlanArguments, settings: Settings, leg: float) -> Request:
    """A walk on stairs; lengths and times that are not given in the robot's size."""
    size = leg / LEG
    rise = 0.05 * size if arguments.rise is None else arguments.rise
    steps = 5 if arguments.steps is None else arguments.steps
    shape = _given(height=arguments.step_height, double_support=arguments.double_support, period=arguments.period)
    length = 0.2 * size if arguments.tread is None else arguments.tread
    step = StepParameters.sized(
        leg,
        length,
        shape.pop("period", 1.2 * size**0.5),
        **({"height": 0.03 * size, "rise": rise, "base": max(0.0, -rise * steps)} | shape),
    )
    return Request("stairs", step=step, settings=settings, cycles=steps - 3)


def _turn(arguments: PlanArguments, settings: Settings, leg: float) -> Request:
    """A turn from rest to rest; times that are not given in the robot's size."""
    angle = 15.0 if arguments.angle is None else arguments.angle
    steps = 5 if arguments.steps is None else arguments.steps
    length = 0.0 if arguments.step_length is None else arguments.step_length
    low, high = RANGES["--step-length"]
    if length and not low <= length <= high:
        raise BadInput("--step-length", length, f"0, or {low:g} to {high:g}")
    if not _ANGLES[0] <= abs(angle) <= _ANGLES[1]:
        raise BadInput("--angle", angle, f"{_ANGLES[0]:g} to {_ANGLES[1]:g} degrees to the left, or negative")
    if steps % 2 == 0:
        raise BadInput("--steps", steps, "an odd number: the inner foot makes the first step and the last one")
    period = leg**0.5 / LEG**0.5 if arguments.period is None else arguments.period
    shape = _given(height=arguments.step_height, double_support=arguments.double_support)
    step = StepParameters.sized(leg, length, period, turn=math.radians(angle), **shape)
    return Request("turn", step=step, settings=settings, cycles=steps - 3)


def _given(**values: Any) -> dict[str, Any]:
    """What was given; the rest keeps its default."""
    return {name: value for name, value in values.items() if value is not None}
