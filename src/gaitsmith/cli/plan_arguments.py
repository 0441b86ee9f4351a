"""The command line of ``gaitsmith plan``: which flags there are, to what each applies, and what they ask for."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.cli.arguments import Positional, choice, integer, number, text
from gaitsmith.errors import BadInput

if TYPE_CHECKING:
    from gaitsmith.synthesis.requests.request import Request

CLAIMS, SWEEP, FILE = "--claims", "sweep", "a motion file"
_WALKS = ("cyclic", "start", "stop", "walk")
_NAMED = (*_WALKS, "kick")
_APPLIES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("speed", "order", "zmp_margin", "friction", "time_limit"), _NAMED),
    **dict.fromkeys(("step_length", "period", "step_height", "double_support"), _WALKS),
    "cycles": ("walk",),
    "jobs": (SWEEP,),
    **dict.fromkeys(("out", "figures"), (*_NAMED, FILE)),
}


def _stride(name: str) -> Callable[[], str]:
    """Default and range of one of speed, step length and period."""

    def shown() -> str:
        from gaitsmith.synthesis.motions.catalogue import KickParameters
        from gaitsmith.synthesis.requests.request import KICK_SPEEDS, RANGES, stride

        length, period = stride(None, None, None)
        low, high = RANGES[name]
        value = {"--speed": length / period, "--step-length": length, "--period": period}[name]
        kick = f", for a kick {KickParameters.speed:g}, from {KICK_SPEEDS[0]:g} to {KICK_SPEEDS[1]:g}"
        return f"{value:g}, from {low:g} to {high:g}" + (kick if name == "--speed" else "")

    return shown


def _step(name: str) -> Callable[[], object]:
    def shown() -> object:
        from gaitsmith.synthesis.motions.catalogue import StepParameters

        return getattr(StepParameters, name)

    return shown


def _bound(name: str) -> Callable[[], object]:
    def shown() -> object:
        from gaitsmith.synthesis.motions.settings import Bounds
        from gaitsmith.synthesis.requests.request import KICK_FRICTION

        value = Bounds.model_fields[name].default
        return f"{value:g}, for a kick {KICK_FRICTION:g}" if name == "friction" else value

    return shown


def _setting(name: str) -> Callable[[], object]:
    def shown() -> object:
        from gaitsmith.synthesis.motions.settings import Settings

        return Settings.model_fields[name].default

    return shown


def _cycles() -> str:
    from gaitsmith.synthesis.requests.request import MOST_CYCLES, Request

    return f"{Request.cycles}, from 0 to {MOST_CYCLES}"


@dataclass(frozen=True)
class PlanArguments:
    """Plan a motion: cyclic, start, stop, walk, kick, sweep, or a motion file (TOML).

    Of speed, step length and period any two decide the third; one alone follows the paper's two gaits.
    """

    motion: Annotated[str | None, Positional, text("MOTION", "MOTION", absent="cyclic")] = None
    """cyclic, start, stop, walk, kick, sweep, or the path of a motion file."""
    robot: Annotated[str, text("--robot", "NAME_OR_PATH")] = "thbip_ii"
    """A robot of the package, or the path of a card."""
    speed: Annotated[float | None, number("--speed", "V", _stride("--speed"))] = None
    """Walking speed, m/s; for a kick the ankle's speed at the ball."""
    step_length: Annotated[float | None, number("--step-length", "M", _stride("--step-length"))] = None
    """From one foothold to the next, m."""
    period: Annotated[float | None, number("--period", "S", _stride("--period"))] = None
    """Of one step, s."""
    step_height: Annotated[float | None, number("--step-height", "M", _step("height"), (0.005, 0.3))] = None
    """Height of the swing ankle above its height on the ground, m."""
    double_support: Annotated[
        float | None, number("--double-support", "SHARE", _step("double_support"), (0.05, 0.8))
    ] = None
    """Share of the period with both feet on the ground."""
    order: Annotated[str | None, choice("--order", ("4", "5"), _setting("order"))] = None
    """Degree of the joint splines: 4 as in the paper, or 5."""
    cycles: Annotated[int | None, integer("--cycles", "N", 0, absent=_cycles)] = None
    """Steps of the cyclic gait in a walk."""
    zmp_margin: Annotated[float | None, number("--zmp-margin", "M", _bound("zmp_margin"), (0.0, 1.0))] = None
    """Distance of the ZMP from the support sole's edge, m."""
    friction: Annotated[float | None, number("--friction", "MU", _bound("friction"), (0.05, 2.0))] = None
    """Coulomb coefficient."""
    time_limit: Annotated[float | None, number("--time-limit", "S", _setting("time_limit"), (0.1, 3600.0))] = None
    """For each solve, s; to find out why there is no solution takes up to 20 s more."""
    jobs: Annotated[int | None, integer("--jobs", "N", 1, 256, absent="1")] = None
    """Processes of a sweep."""
    out: Annotated[str | None, text("--out", "FILE", absent="none")] = None
    """Gait file to write."""
    figures: Annotated[str | None, text("--figures", "DIR", absent="none")] = None
    """New folder for figures (PNG)."""
    claims: bool = False
    """Plan the paper's two cyclic gaits and print its claims beside our figures."""
    json: bool = False
    """Print one JSON document instead of tables."""


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
        if value is not None and task not in tasks:
            raise BadInput("--" + name.replace("_", "-"), value, f"nothing with {task}", f"for {', '.join(tasks)} only")
    return task


def request_from(arguments: PlanArguments, task: str) -> Request | None:
    """The request that the flags describe; None for a motion file.

    Raises:
        BadInput: naming the flag.
    """
    if task == FILE:
        return None
    from gaitsmith.synthesis.motions.catalogue import KickParameters, StepParameters
    from gaitsmith.synthesis.motions.settings import Bounds, Settings
    from gaitsmith.synthesis.requests.request import KICK_FRICTION, KICK_SPEEDS, Request, stride

    friction = KICK_FRICTION if task == "kick" and arguments.friction is None else arguments.friction
    bounds = Bounds(**_given(zmp_margin=arguments.zmp_margin, friction=friction))
    order = None if arguments.order is None else int(arguments.order)
    settings = Settings(bounds=bounds, **_given(order=order, time_limit=arguments.time_limit))
    if task == "kick":
        if arguments.speed is not None and not KICK_SPEEDS[0] <= arguments.speed <= KICK_SPEEDS[1]:
            raise BadInput("--speed", arguments.speed, f"{KICK_SPEEDS[0]:g} to {KICK_SPEEDS[1]:g} for a kick")
        return Request("kick", kick=KickParameters(**_given(speed=arguments.speed)), settings=settings)
    length, period = stride(arguments.speed, arguments.step_length, arguments.period)
    shape = _given(height=arguments.step_height, double_support=arguments.double_support)
    step = StepParameters(length, period, **shape)
    return Request(task, step=step, settings=settings, **_given(cycles=arguments.cycles))  # type: ignore[arg-type]


def _given(**values: Any) -> dict[str, Any]:
    """What was given; the rest keeps its default."""
    return {name: value for name, value in values.items() if value is not None}
