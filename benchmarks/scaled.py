"""A robot of another size and the same shape: the model and the card scaled, gravity being the same.

    python benchmarks/scaled.py ROBOT FACTOR FOLDER

Prints the path of the scaled card. Lengths go with the factor s, masses with s³, torques with s⁴, inertias with s⁵,
times with √s. A walk of one then is a walk of the other, seen from another distance.
"""

from __future__ import annotations

import sys
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

from gaitsmith.robots import load_robot

LENGTH, MASS, TORQUE, INERTIA, TIME, SPEED, RATE = 1.0, 3.0, 4.0, 5.0, 0.5, 0.5, -0.5
MODEL = {
    **dict.fromkeys(("pos", "size", "fromto"), LENGTH),
    **dict.fromkeys(("diaginertia", "fullinertia", "armature"), INERTIA),
    **dict.fromkeys(("ctrlrange", "forcerange", "actuatorfrcrange", "frictionloss", "stiffness"), TORQUE),
    "mass": MASS,
    "damping": TORQUE + TIME,
}
"""Power of s in each attribute of the model."""
CARD = {
    **dict.fromkeys(("heel", "toe", "half_width", "sole_position"), LENGTH),
    **dict.fromkeys(("height", "lift", "width"), LENGTH),
    **dict.fromkeys(("speed", "speed_x", "speed_y"), SPEED),
    **dict.fromkeys(("velocity", "yaw_rate"), RATE),
    **dict.fromkeys(("normal_force",), MASS),
    **dict.fromkeys(("swing_stiffness", "stance_stiffness", "torque"), TORQUE),
    **dict.fromkeys(("swing_damping", "stance_damping"), TORQUE + TIME),
    "mass": MASS,
    "period": TIME,
}
"""Power of s in each entry of the card; gains without a unit are not here."""


def write_scaled(name: str, factor: float, folder: Path) -> Path:
    """Write a scaled robot's model and card into a folder.

    Args:
        name: name or path of an MJCF robot.
        factor: s, of lengths.
        folder: created if it is not there.

    Returns:
        Path of the card.
    """
    robot = load_robot(name)
    card = tomllib.loads(robot.model_path.with_name("card.toml").read_text())
    tree = ElementTree.parse(robot.model_path)
    for element in tree.iter():
        for key, value in element.attrib.items():
            if key in MODEL:
                numbers = (float(word) * factor ** MODEL[key] for word in value.split())
                element.set(key, " ".join(f"{number:.10g}" for number in numbers))
    folder.mkdir(parents=True, exist_ok=True)
    tree.write(folder / robot.model_path.name)
    scaled = _scaled(card, factor) | {"name": f"{card['name']}_x{factor:g}", "model": robot.model_path.name}
    path = folder / "card.toml"
    path.write_text("".join(f"{key} = {_inline(value)}\n" for key, value in scaled.items()))
    return path


def _scaled(value: Any, factor: float, key: str = "") -> Any:
    """Every number by the power that its key has."""
    if isinstance(value, dict):
        return {name: _scaled(entry, factor, name) for name, entry in value.items()}
    if isinstance(value, list):
        return [_scaled(entry, factor, key) for entry in value]
    if key in CARD and isinstance(value, int | float):
        return float(f"{value * factor ** CARD[key]:.10g}")
    return value


def _inline(value: Any) -> str:
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_inline(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return str(value).lower() if isinstance(value, bool) else repr(value)


if __name__ == "__main__":
    print(write_scaled(sys.argv[1], float(sys.argv[2]), Path(sys.argv[3])))
