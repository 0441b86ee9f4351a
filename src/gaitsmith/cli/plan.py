"""``gaitsmith plan``: a motion planned, checked between the points, certified, and written as a gait file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.cli.arguments import Positional, choice, integer, number, parse, text
from gaitsmith.cli.dispatch import DONE, Outcome
from gaitsmith.errors import BadInput

if TYPE_CHECKING:
    from gaitsmith.synthesis.request import Answer, Request

NOT_SOLVED = 3


@dataclass(frozen=True)
class PlanArguments:
    """Plan a motion: cyclic, start, stop, walk, kick, sweep, or a motion file (TOML).

    Of speed, step length and period any two decide the third; one alone follows the paper's two gaits.
    """

    motion: Annotated[str, Positional, text("MOTION", "MOTION")] = "cyclic"
    """cyclic, start, stop, walk, kick, sweep, or the path of a motion file."""
    robot: Annotated[str, text("--robot", "NAME_OR_PATH")] = "thbip_ii"
    """A robot of the package, or the path of a card."""
    speed: Annotated[float | None, number("--speed", "V")] = None
    """Walking speed, m/s; for a kick the ankle's speed at the ball."""
    step_length: Annotated[float | None, number("--step-length", "M")] = None
    """From one foothold to the next, m."""
    period: Annotated[float | None, number("--period", "S")] = None
    """Of one step, s."""
    step_height: Annotated[float | None, number("--step-height", "M")] = None
    """Height of the swing ankle above its height on the ground, m."""
    double_support: Annotated[float | None, number("--double-support", "SHARE")] = None
    """Share of the period with both feet on the ground."""
    order: Annotated[str, choice("--order", ("4", "5"))] = "5"
    """Degree of the joint splines: 4 as in the paper, or 5."""
    cycles: Annotated[int, integer("--cycles", "N", 0)] = 10
    """Steps of the cyclic gait in a walk."""
    zmp_margin: Annotated[float | None, number("--zmp-margin", "M")] = None
    """Distance of the ZMP from the support sole's edge, m."""
    friction: Annotated[float | None, number("--friction", "MU")] = None
    """Coulomb coefficient."""
    time_limit: Annotated[float, number("--time-limit", "S")] = 60.0
    """For each solve, s."""
    jobs: Annotated[int, integer("--jobs", "N", 1)] = 1
    """Processes of a sweep."""
    out: Annotated[str | None, text("--out", "FILE")] = None
    """Gait file to write."""
    figures: Annotated[str | None, text("--figures", "DIR")] = None
    """New folder for figures (PNG)."""
    claims: bool = False
    """Plan the paper's two cyclic gaits and print its claims beside our figures."""
    json: bool = False
    """Print one JSON document instead of tables."""


def plan(words: list[str], program: str) -> Outcome:
    """Run the command.

    Raises:
        BadInput: the command line, the motion or the robot cannot be used.
    """
    arguments = parse(PlanArguments, words, program)
    _check_out(arguments)
    if arguments.claims:
        from gaitsmith.cli.claims import claims

        return claims(arguments.robot)
    if arguments.motion == "sweep":
        from gaitsmith.cli.sweep import sweep

        return sweep(arguments.robot, arguments.jobs)
    from gaitsmith.robots import load_robot
    from gaitsmith.synthesis import Planner, plan_document, write_gait

    request = request_from(arguments)
    robot = load_robot(arguments.robot)
    with _Display(arguments.json) as display:
        planner = Planner(robot, display.say)
        found = _solve(planner, request, arguments.motion, display)
    file = None
    kind = request.kind if request is not None else Path(arguments.motion).stem
    if found.gait is not None and arguments.out is not None:
        write_gait(arguments.out, found.gait)
        file = str(Path(arguments.out).resolve())
    document = plan_document(found, kind, planner.biped, file)
    if found.gait is not None and arguments.figures is not None:
        from gaitsmith.view.gait_figures import write_gait_figures

        document["figures"] = [str(path) for path in write_gait_figures(found.gait, robot, Path(arguments.figures))]
    code = DONE if found.gait is not None else NOT_SOLVED
    if found.gait is None:
        display.say(f"{found.main.status}: {found.main.reason}")

    def show() -> None:
        from gaitsmith.cli.plan_report import print_plan

        print_plan(document, robot)

    return Outcome(code, document, show)


def request_from(arguments: PlanArguments) -> Request | None:
    """The request that the flags describe; None for a motion file.

    Raises:
        BadInput: naming the flag.
    """
    from gaitsmith.synthesis.motions import KickParameters, StepParameters
    from gaitsmith.synthesis.request import KICK_FRICTION, KINDS, Request, stride
    from gaitsmith.synthesis.settings import Bounds, Settings

    _range("--zmp-margin", arguments.zmp_margin, 0.0, 0.04)
    _range("--friction", arguments.friction, 0.05, 2.0)
    _range("--time-limit", arguments.time_limit, 0.1, 3600.0)
    _range("--step-height", arguments.step_height, 0.005, 0.3)
    _range("--double-support", arguments.double_support, 0.05, 0.8)
    changed: dict[str, Any] = {}
    if arguments.zmp_margin is not None:
        changed["zmp_margin"] = arguments.zmp_margin
    if arguments.friction is not None:
        changed["friction"] = arguments.friction
    elif arguments.motion == "kick":
        changed["friction"] = KICK_FRICTION
    settings = Settings(
        order=4 if arguments.order == "4" else 5, bounds=Bounds(**changed), time_limit=arguments.time_limit
    )
    if arguments.motion not in KINDS:
        if not Path(arguments.motion).is_file():
            raise BadInput("MOTION", arguments.motion, f"{', '.join(KINDS)}, sweep, or a motion file (TOML)")
        return None
    if arguments.motion == "kick":
        _range("--speed", arguments.speed, 0.1, 20.0)
        for flag, given in (("--step-length", arguments.step_length), ("--period", arguments.period)):
            if given is not None:
                raise BadInput(flag, given, "nothing for a kick", "a kick takes --speed, the ankle's speed at the ball")
        kick = KickParameters(speed=2.0 if arguments.speed is None else arguments.speed)
        return Request("kick", kick=kick, settings=settings)
    length, period = stride(arguments.speed, arguments.step_length, arguments.period)
    extra: dict[str, float] = {}
    if arguments.step_height is not None:
        extra["height"] = arguments.step_height
    if arguments.double_support is not None:
        extra["double_support"] = arguments.double_support
    step = StepParameters(length, period, **extra)
    return Request(arguments.motion, step=step, cycles=arguments.cycles, settings=settings)


def _solve(planner: Any, request: Request | None, motion: str, display: _Display) -> Answer:
    from gaitsmith.synthesis.request import answer

    if request is not None:
        return answer(planner, request, display.report)
    from gaitsmith.synthesis.motion_file import answer_file

    return answer_file(planner, Path(motion), display.report)


def _range(flag: str, value: float | None, low: float, high: float) -> None:
    if value is not None and not low <= value <= high:
        raise BadInput(flag, value, f"{low:g} to {high:g}")


def _check_out(arguments: PlanArguments) -> None:
    """Refuse an output that cannot be written before minutes are spent on it."""
    if arguments.out is not None:
        folder = Path(arguments.out).absolute().parent
        if not folder.is_dir():
            raise BadInput("--out", arguments.out, "a file in a folder that exists")
        if Path(arguments.out).is_dir():
            raise BadInput("--out", arguments.out, "a file, not a folder")
    if arguments.figures is not None and Path(arguments.figures).exists():
        raise BadInput("--figures", arguments.figures, "a folder that does not exist yet", "choose another name")


class _Display:
    """Live progress on stderr, if that is a terminal; notices always."""

    def __init__(self, quiet: bool) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        self._console = Console(stderr=True)
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[done]}"),
            TimeElapsedColumn(),
        )
        self._progress = Progress(
            *columns, console=self._console, transient=True, disable=not self._console.is_terminal
        )
        self._task = self._progress.add_task("loading", total=None, done="")

    def __enter__(self) -> _Display:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def say(self, text: str) -> None:
        """A notice."""
        self._console.print(f"gaitsmith: {text}", highlight=False, soft_wrap=True, markup=False)

    def report(self, motion: str, rounds: int, progress: Any) -> None:
        """One iteration."""
        done = f"iteration {progress.iteration}, objective {progress.objective:.4g}, worst {_physical(progress)}"
        name = f"planning {motion}" + (f", refinement {rounds}" if rounds else "")
        self._progress.update(self._task, description=name, done=done)


def _physical(progress: Any) -> str:
    """The worst violation in its own unit."""
    if not progress.constraint:
        return f"{progress.violation:.2g}"
    return f"{progress.constraint} by {progress.violation * progress.span:.2g} {progress.unit}".rstrip()
