"""``gaitsmith verify``: all that a gait file says, recomputed without the planner, or proved for all times."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, GaitFile, OwnRobot, parse
from gaitsmith.cli.dispatch import DONE, FELL, Outcome
from gaitsmith.cli.inputs import planned_gait
from gaitsmith.cli.plan_report import verdict_lines
from gaitsmith.documents import About
from gaitsmith.errors import BadInput


class VerifyArguments(Arguments):
    """Check all that a gait file says against MuJoCo's kinematics and inverse dynamics."""

    gait: GaitFile
    robot: OwnRobot = None
    dense: Annotated[int, Field(ge=50, le=5000), About("Instants in every phase", metavar="N")] = 200
    rigorous: Annotated[bool, About("Also prove every bound for all times, not only for instants")] = False
    box: Annotated[
        str | None,
        About(
            "With --rigorous: errors under which stability is proved, as mass=.05,friction=.5:1,foothold=.01",
            metavar="NAME=ERROR,...",
        ),
    ] = None


def verify(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(VerifyArguments, words, program)
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis import verify as check
    from gaitsmith.synthesis.proof.box import box_from
    from gaitsmith.synthesis.proof.rigorous import proof_of

    if arguments.box is not None and not arguments.rigorous:
        raise BadInput("--box", arguments.box, "an option of --rigorous", "give both")
    box = None if arguments.box is None else box_from(arguments.box)
    gait, robot, intact = planned_gait(arguments.gait, arguments.robot, allow_edited=True)
    with Display() as display:
        tell = lambda done, total: display.show("verifying", f"phase {done} of {total}", done, total)  # noqa: E731
        verdict = check(gait, robot, arguments.dense, tell)
        if arguments.rigorous:
            show = lambda done, total: display.show("proving", f"phase {done} of {total}", done, total)  # noqa: E731
            verdict.rigorous, problems = proof_of(gait, robot, box, show)
            verdict.problems += problems
    if not intact:
        verdict.problems.insert(0, "the file was edited: its checksum does not hold")
    document = verdict.as_dict() | {"file": arguments.gait, "robot": robot.card.name, "motion": gait.motion.name}
    return Outcome(DONE if verdict.ok else FELL, document, verdict_lines(document))
