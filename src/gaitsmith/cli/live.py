"""``gaitsmith live``: a page to watch and steer a walk, or to replay a run."""

from __future__ import annotations

import sys
from typing import Annotated, Any

from pydantic import Field

from gaitsmith.cli.arguments import Arguments, Positional, as_flag, flag, overriding, parse
from gaitsmith.cli.dispatch import DONE, Outcome, printable
from gaitsmith.cli.inputs import named_robot, tell_old_card
from gaitsmith.cli.interrupts import stop_if_heard
from gaitsmith.documents import About
from gaitsmith.errors import BadInput
from gaitsmith.files import uninterrupted
from gaitsmith.simulation.scenario import Scenario, make_scenario

DEFAULT = {"speed": [0.3, 0.0]}
"""What the page walks at first."""
_NOT_HERE = ("pushes", "duration", "rest_before", "rest_after")
_ENDLESS = 1e6  # s


class _Live(Arguments):
    """Open a page that shows a robot walking in real time and lets you steer, push and record it.

    Without RUN it walks; with the folder of a recorded run it replays it. Open the address that it prints in a browser;
    Ctrl-C ends it.
    """

    run: Annotated[str | None, Positional("Folder of a recorded run, to replay it", metavar="RUN")] = None
    host: Annotated[
        str, About("Where the page is to be found; other machines reach 0.0.0.0, by a token", metavar="ADDRESS")
    ] = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535), About("Its port; 0 for any free one", metavar="N")] = 8080
    out: Annotated[str, About("Folder in which recordings get folders of their own", metavar="DIR")] = "runs"


LiveArguments = overriding(_Live, Scenario, "the robot's", DEFAULT, without=_NOT_HERE)


def live(words: list[str], program: str) -> Outcome:
    """Run the command."""
    arguments = parse(LiveArguments, words, program)
    given = arguments.model_dump(mode="json", exclude_none=True, exclude=set(_Live.model_fields))
    if arguments.run is None:
        return _walk(arguments, given)
    if given:
        raise BadInput(flag(next(iter(given))), given[next(iter(given))], "nothing beside RUN", "the run says it")
    return _replay(arguments, arguments.run)


def _walk(arguments: _Live, given: dict[str, Any]) -> Outcome:
    """A walk that can be steered."""
    from gaitsmith.cli.display import Display
    from gaitsmith.live.session import Session
    from gaitsmith.robots.footing import check_soles

    scenario = _scenario(given)
    robot = named_robot(scenario["robot"])
    check_soles(robot)
    with Display("loading (the first time compiles)"):
        try:
            session = Session(scenario, robot, arguments.host, arguments.port, arguments.out)
        except BadInput as error:
            raise as_flag(error, LiveArguments) from None
    recorded: list[str] = []
    try:
        _tell(session.address)
        session.run(stop_if_heard)
    except KeyboardInterrupt:
        pass
    finally:
        with uninterrupted():
            recorded = session.close()
    return _ended(session.address, [f"recorded: {folder}" for folder in recorded], {"recorded": recorded})


def _replay(arguments: _Live, path: str) -> Outcome:
    """A run that was recorded."""
    import gaitsmith.live.server  # noqa: F401 - the extra, before anything that takes long
    from gaitsmith.live.replay import Replay
    from gaitsmith.live.run import Run

    run = Run(path)
    tell_old_card(run.robot)
    for note in run.notes:
        sys.stderr.write(printable(f"gaitsmith: {note}\n"))
    page = Replay(run, arguments.host, arguments.port)
    try:
        _tell(page.address)
        page.run(stop_if_heard)
    except KeyboardInterrupt:
        pass
    finally:
        page.close()
    return _ended(page.address, [], {"run": path, "notes": run.notes})


def _scenario(given: dict[str, Any]) -> dict[str, Any]:
    """Fields of the walk: what the options give over the defaults, without an end.

    Raises:
        BadInput: naming the option.
    """
    try:
        if given.get("gait"):
            from gaitsmith.simulation.planned_run import completed

            fields = completed(given)
        else:
            fields = {**DEFAULT, **given}
        scenario = make_scenario({**fields, "duration": _ENDLESS})
    except BadInput as error:
        raise as_flag(error, LiveArguments) from None
    return scenario.model_dump(mode="json", exclude_none=True)


def _tell(address: str) -> None:
    """Where the page is; at once, also into a pipe."""
    sys.stderr.write(f"gaitsmith: open {address} in a browser; Ctrl-C ends it\n")
    sys.stderr.flush()


def _ended(address: str, text: list[str], document: dict[str, Any]) -> Outcome:
    """It was ended by Ctrl-C, which is how it ends."""
    return Outcome(DONE, {"address": address.partition("?")[0], **document}, text)
