"""``gaitsmith verify``: the certificate of a gait file, recomputed by MuJoCo alone."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, GaitFile, OwnRobot, parse
from gaitsmith.cli.dispatch import DONE, FELL, Outcome
from gaitsmith.cli.inputs import planned_gait
from gaitsmith.cli.plan_report import verdict_lines
from gaitsmith.documents import About


class VerifyArguments(Arguments):
    """Check a gait file against MuJoCo's kinematics and inverse dynamics."""

    gait: GaitFile
    robot: OwnRobot = None
    dense: Annotated[int, Field(ge=50, le=5000), About("Instants in every phase", metavar="N")] = 400


def verify(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(VerifyArguments, words, program)
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis import verify as check

    gait, robot, intact = planned_gait(arguments.gait, arguments.robot, allow_edited=True)
    with Display() as display:
        tell = lambda done, total: display.show("verifying", f"phase {done} of {total}", done, total)  # noqa: E731
        verdict = check(gait, robot, arguments.dense, tell)
    if not intact:
        verdict.problems.insert(0, "the file was edited: its checksum does not hold")
    document = verdict.as_dict() | {"file": arguments.gait, "robot": robot.card.name, "motion": gait.motion.name}
    return Outcome(DONE if verdict.ok else FELL, document, verdict_lines(document))
