"""``gaitsmith robots``: what robots there are, what one consists of, and whether a card can be used."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.cli.arguments import Arguments, Positional, parse
from gaitsmith.cli.dispatch import DONE, FELL, Outcome, Table, Text
from gaitsmith.cli.inputs import gait_units, named_robot
from gaitsmith.documents import About

if TYPE_CHECKING:
    from gaitsmith.adoption.trials import Test
    from gaitsmith.robots import Robot


class ListArguments(Arguments):
    """List the robots that come with the package."""


class RobotArguments(Arguments):
    """Load a robot, check it, and describe it."""

    robot: Annotated[
        str,
        Positional("A robot of the package, the path of a card, or a folder with a card.toml", metavar="NAME_OR_PATH"),
    ] = "bhr_b2"


class CheckArguments(RobotArguments):
    """Load a robot, lay its soles on the ground, and let it stand for 8 s and walk for 20 s at 0.1 m/s."""

    no_tests: Annotated[bool, About("Do not let it stand and walk")] = False


def list_robots(words: list[str], program: str) -> Outcome:
    """Run ``robots list``."""
    parse(ListArguments, words, program)
    from gaitsmith.robots import load_robot, robot_names

    robots = [load_robot(name) for name in robot_names()]
    entries = [{"name": robot.card.name, "description": robot.card.description, "mass": robot.mass} for robot in robots]
    width = max((len(robot.card.name) for robot in robots), default=0)
    text = [f"{robot.card.name:<{width}}  {robot.mass:6.1f} kg  {robot.card.description}" for robot in robots]
    return Outcome(DONE, {"robots": entries}, text)


def show(words: list[str], program: str) -> Outcome:
    """Run ``robots show``."""
    robot = named_robot(parse(RobotArguments, words, program).robot, "ROBOT")
    from gaitsmith.robots import describe

    document = describe(robot)
    return Outcome(DONE, document, _lines(robot, document))


def check(words: list[str], program: str) -> Outcome:
    """Run ``robots check``; exit code 1 if it does not stand or walk."""
    options = parse(CheckArguments, words, program)
    robot = named_robot(options.robot, "ROBOT")
    from gaitsmith.kinematics.posture import standing_posture
    from gaitsmith.robots.footing import check_soles

    check_soles(robot)
    gait = robot.card.gait
    posture = standing_posture(robot, gait.height, gait.width)
    angles = dict(zip(robot.joint_names, posture[7:].tolist(), strict=True))
    tests = () if options.no_tests else _tested(robot, options.robot)
    document = {
        "ok": all(test.ok for test in tests),
        "name": robot.card.name,
        "mass": robot.mass,
        "joints": list(robot.joint_names),
        "presets": sorted(robot.card.presets),
        "standing": angles,
        "notes": list(robot.notes),
        "tests": {test.name: test.document() for test in tests},
    }
    bent = [name for leg in robot.legs for name in leg.joints if abs(angles[name]) > 5e-4]
    text = [
        f"{robot.card.name}: card and model fit; {robot.mass:.3f} kg, {len(robot.joint_names)} joints",
        f"stands with its hips at {gait.height:.4g} m: {', '.join(f'{name} {angles[name]:+.3f}' for name in bent)}",
        *(f"note: {note}" for note in robot.notes),
        *(test.line() for test in tests),
    ]
    return Outcome(DONE if document["ok"] else FELL, document, text)


def _tested(robot: Robot, name: str) -> tuple[Test, ...]:
    """The tests that an adopted robot has to pass."""
    from gaitsmith.adoption.trials import examine
    from gaitsmith.cli.display import Display

    with Display("loading (the first time compiles)") as display:
        return examine(robot, name, progress=display.advance).tests


def _lines(robot: Robot, document: dict[str, Any]) -> Iterator[Text]:
    """Legs, gait, limits and assumptions."""
    card, legs = robot.card, sum(len(leg.joints) for leg in robot.legs)
    yield f"{card.name}: {card.description or 'a biped'}"
    yield f"{robot.mass:.3f} kg, {len(robot.joint_names)} joints, {legs} of them in the legs; torso {card.torso}"
    yield f"model: {document['model_path']}"
    for leg in robot.legs:
        sole = leg.sole
        size = f"heel {sole.heel:g} m, toe {sole.toe:g} m" + (f", ±{sole.half_width:g} m" if sole.half_width else "")
        yield f"{leg.name} leg: {', '.join(leg.joints)}; {sole.kind} sole {leg.sole_site}, {size}"
    rows = [
        (name, *(f"{value:.4g}" for value in (*limit["position"], limit["velocity"], limit["torque"])))
        for name, limit in document["limits"].items()
    ]
    yield Table(("joint", "from", "to", "speed\nper s", "torque\nN·m"), rows)
    yield Table(("gait", "default", "from", "to"), list(_gait(document)))
    yield f"presets: {', '.join(document['presets'])}"
    for assumption in card.assumptions:
        yield f"assumed: {assumption.what}: {assumption.value} ({assumption.why})"
    yield from (f"note: {note}" for note in robot.notes)


def _gait(document: dict[str, Any]) -> Iterator[tuple[str, ...]]:
    """Inputs of a walk with their default and limits."""
    from gaitsmith.robots.parameters import gait_numbers

    gait, units = {part: value for part, _, value in gait_numbers(document["gait"])}, gait_units()
    for name, (low, high) in document["gait_limits"].items():
        yield (
            f"{name}, {units[name]}" if units[name] else name,
            *(f"{value:.4g}" for value in (gait[name], low, high)),
        )
