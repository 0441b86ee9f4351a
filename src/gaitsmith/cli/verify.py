"""``gaitsmith verify``: the certificate of a gait file, recomputed by MuJoCo alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from gaitsmith.cli.arguments import Positional, integer, parse, text
from gaitsmith.cli.dispatch import DONE, FELL, Outcome
from gaitsmith.cli.inputs import planned_gait


@dataclass(frozen=True)
class VerifyArguments:
    """Check a gait file against MuJoCo's kinematics and inverse dynamics."""

    gait: Annotated[str, Positional, text("GAIT", "GAIT")]
    """Gait file."""
    robot: Annotated[str | None, text("--robot", "NAME_OR_PATH", absent="the one it names")] = None
    """The robot it was planned for, if it is not one of the package."""
    dense: Annotated[int, integer("--dense", "N", 50, 5000)] = 400
    """Instants in every phase."""
    json: bool = False
    """Print one JSON document instead of tables."""


def verify(words: list[str], program: str) -> Outcome:
    """Run the command.

    Raises:
        BadInput: the command line, the file or the robot cannot be used.
    """
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

    def show() -> None:
        from gaitsmith.cli.plan_report import print_verdict

        print_verdict(document)

    return Outcome(DONE if verdict.ok else FELL, document, show)
