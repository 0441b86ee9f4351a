"""What commands read: a robot by name or path, and a gait file with the robot that it is for."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from gaitsmith.errors import BadInput

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gaitsmith.robots import Robot
    from gaitsmith.synthesis import Gait


def named_robot(name: str, field: str = "--robot") -> Robot:
    """The robot of that name, or of the card at that path.

    Raises:
        BadInput: it cannot be loaded; a name that is unknown is reported under ``field``.
    """
    from gaitsmith.robots import load_robot

    try:
        robot = load_robot(name)
    except BadInput as error:
        if error.field == "robot":
            raise BadInput(field, error.value, error.valid, "see gaitsmith robots list") from None
        raise
    tell_old_card(robot)
    return robot


def gait_units() -> dict[str, str]:
    """Unit of every number of the gait, by its name in the limits."""
    from gaitsmith.robots.parameters import GAIT_INPUTS

    return {part: about.unit for name, about in GAIT_INPUTS.items() for part in about.parts or (name,)}


def require_ending(out: str | None, flag: str, chosen: str, endings: Mapping[str, str]) -> None:
    """Refuse a file name that ends as another format's files do.

    Args:
        out: the file; None: nothing to refuse.
        flag: of the format.
        chosen: the format.
        endings: of every format's files.

    Raises:
        BadInput: naming the format that the name asks for.
    """
    other = next((form for form, end in endings.items() if out is not None and out.lower().endswith(end)), chosen)
    if other != chosen:
        raise BadInput(
            "--out", out, f"a name that does not end in {endings[other]} for {chosen}", f"give {flag} {other}"
        )


def tell_old_card(robot: Robot) -> None:
    """Say on stderr what an old card no longer means."""
    from gaitsmith.robots.card_file import OLD_NOTE

    if OLD_NOTE in robot.notes:
        sys.stderr.write(f"gaitsmith: note: {OLD_NOTE}\n")


def planned_gait(path: str, robot: str | None, allow_edited: bool = False) -> tuple[Gait, Robot, bool]:
    """The gait in a file, its robot, and whether the file is as it was written.

    Args:
        robot: where the robot is, if it is not one of the package.
        allow_edited: hand back a well-formed file that was edited, instead of refusing it.

    Raises:
        BadInput: file or robot cannot be used, or do not belong together.
    """
    from gaitsmith.synthesis.files.gait_file import load_robot_of, read_gait, require_robot

    gait, intact = read_gait(path, allow_edited=allow_edited)
    if robot is None:
        return gait, load_robot_of(gait), intact
    loaded = named_robot(robot)
    if gait.robot_hash != loaded.content_hash:
        valid = f"the robot that the gait was planned for, {gait.robot[:60]} with hash {gait.robot_hash[:12]}"
        raise BadInput("--robot", robot, valid, "plan again for this one")
    require_robot(gait, loaded)
    return gait, loaded, intact
