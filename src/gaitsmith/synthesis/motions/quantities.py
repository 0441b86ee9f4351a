"""What a motion may bound or fix, by name, with units."""

from __future__ import annotations

from typing import Literal, NamedTuple


class Quantity(NamedTuple):
    """A number of the other foot, its ankle, the torso, or the centre of mass that a motion may bound or fix.

    Attributes:
        part: of the robot.
        axis: x, y or z; of an angle roll, pitch or yaw.
        unit: m, m/s or rad.
    """

    part: Literal[
        "ankle",
        "ankle velocity",
        "sole",
        "toe",
        "heel",
        "foot",
        "hip",
        "torso",
        "support",
        "centre",
        "centre velocity",
        "body",
    ]
    axis: int
    unit: str


_PLACES, _ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")
QUANTITIES: dict[str, Quantity] = {
    **{f"ankle_{name}": Quantity("ankle", k, "m") for k, name in enumerate(_PLACES)},
    **{f"ankle_v{name}": Quantity("ankle velocity", k, "m/s") for k, name in enumerate(_PLACES)},
    **{f"sole_{name}": Quantity("sole", k, "m") for k, name in enumerate(_PLACES)},
    "toe_x": Quantity("toe", 0, "m"),
    "toe_z": Quantity("toe", 2, "m"),
    "heel_x": Quantity("heel", 0, "m"),
    "heel_z": Quantity("heel", 2, "m"),
    **{f"foot_{name}": Quantity("foot", k, "rad") for k, name in enumerate(_ANGLES)},
    "hip_height": Quantity("hip", 2, "m"),
    "support_z": Quantity("support", 2, "m"),
    **{f"torso_{name}": Quantity("torso", k, "rad") for k, name in enumerate(_ANGLES)},
    **{f"torso_{name}": Quantity("body", k, "m") for k, name in enumerate(_PLACES)},
    **{f"com_{name}": Quantity("centre", k, "m") for k, name in enumerate(_PLACES)},
    **{f"com_v{name}": Quantity("centre velocity", k, "m/s") for k, name in enumerate(_PLACES)},
}


JOINT_QUANTITIES = {"angle": "rad", "velocity": "rad/s", "acceleration": "rad/s²", "torque": "N·m"}
"""What of a joint a motion may bound or fix, as the quantity ``NAME.angle``, and in which unit."""


RATE = "torque_rate"
"""The largest change of every joint's torque with time, N·m/s, as the quantity of a limit."""


def of_joint(quantity: str) -> tuple[str, str] | None:
    """The joint, and what of it, that a quantity is about; None for one of :data:`QUANTITIES`."""
    name, _, what = quantity.rpartition(".")
    return (name, what) if name and what in JOINT_QUANTITIES else None


def unit_of(quantity: str) -> str:
    """Of a quantity's value; rad where its sine is counted."""
    joint = of_joint(quantity)
    if quantity == RATE:
        return "N·m/s"
    return QUANTITIES[quantity].unit if joint is None else JOINT_QUANTITIES[joint[1]]


def by_sine(quantity: str) -> bool:
    """Whether the value of a quantity is the sine of an angle."""
    return of_joint(quantity) is None and unit_of(quantity) == "rad"
