"""``gaitsmith plan``: a motion planned, checked between the points, certified, and written as a gait file."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsmith.cli.arguments import as_flag, parse
from gaitsmith.cli.dispatch import DONE, NOT_SOLVED, Outcome
from gaitsmith.cli.inputs import named_robot
from gaitsmith.cli.plan_arguments import CLAIMS, SWEEP, PlanArguments, request_from, task_of
from gaitsmith.cli.plan_report import plan_lines
from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.files import uninterrupted
from gaitsmith.simulation.run_folder import NewFolder, check_file, check_new_folder

if TYPE_CHECKING:
    from gaitsmith.robots import Robot
    from gaitsmith.synthesis import Gait


def plan(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(PlanArguments, words, program)
    task = task_of(arguments)
    if task == CLAIMS:
        from gaitsmith.cli.many_plans import claims

        return claims(arguments.robot)
    if task == SWEEP:
        from gaitsmith.cli.many_plans import sweep

        return sweep(arguments.robot, arguments.jobs or 1)
    inputs = (arguments.motion or "", arguments.robot)
    out = check_file(arguments.out, inputs) if arguments.out is not None else None
    figures = check_new_folder(arguments.figures, "--figures") if arguments.figures is not None else None
    if out is not None and out == figures:
        raise BadInput("--figures", arguments.figures, "another name than that of the gait file")
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis import Planner, answer, answer_file, plan_document

    robot = named_robot(arguments.robot)
    given = list(arguments.model_dump(exclude_none=True))
    planner = Planner(robot, free=arguments.free)
    request = request_from(arguments, task, planner.biped.height, planner.biped.usual_period)
    with Display() as display:
        try:
            planner.notify = display.slow
            if request is not None:
                found = answer(planner, request, display.iteration)
            else:
                found = answer_file(planner, Path(arguments.motion or ""), display.iteration)
        except BadInput as error:
            raise as_flag(error, PlanArguments, given) from None
        kind = request.kind if request is not None else Path(arguments.motion or "").stem
        document = plan_document(found, kind, planner.biped, None if out is None or found.gait is None else str(out))
        if found.gait is not None:
            display.show("writing")
            document["figures"] = _write(found.gait, robot, out, figures, display.say)
        else:
            display.say(f"{found.main.status}: {found.main.reason}")
    return Outcome(DONE if document["verified"] else NOT_SOLVED, document, plan_lines(document, robot))


def _write(gait: Gait, robot: Robot, out: Path | None, figures: Path | None, say: Callable[[str], None]) -> list[str]:
    """Gait file and figures, in the end both or neither; returns the figures' paths.

    Drawing may be interrupted, and then nothing is left of it; what follows may not. Figures that cannot be drawn cost
    nothing but themselves.
    """
    from gaitsmith.synthesis import write_gait

    paths: list[str] = []
    with contextlib.ExitStack() as undone:
        if figures is not None:
            from gaitsmith.view.gait_figures import write_gait_figures

            folder = NewFolder(figures, "--figures")
            undone.callback(folder.discard)
            folder.make()
            try:
                paths = [str(path) for path in write_gait_figures(gait, robot, figures)]
            except GaitsmithError:
                raise
            except Exception as error:  # the plan is worth more than its figures
                say(f"no figures: {type(error).__name__}: {error}")
                folder.discard()
        with uninterrupted():
            if out is not None:
                write_gait(out, gait)
            undone.pop_all()
    return paths
