"""The default parameters are the same numbers for every robot, in its own units of length, time and mass."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from tests.control.walking import ROBOTS, parameters, robot

from gaitsmith.control.defaults import Scale, default_parameters, preset_parameters, robot_scale
from gaitsmith.errors import BadInput
from gaitsmith.robots.presets import ControlParameters

# Powers of length, time and mass in each entry; an entry that is not here has no unit, or is a sensor's noise.
L, T, M = (1, 0, 0), (0, 1, 0), (0, 0, 1)
FORCE, TORQUE, SPEED, STIFFNESS, RATE = (1, -2, 1), (2, -2, 1), (1, -1, 0), (0, -2, 0), (0, -1, 0)
TORQUES = (-4, 4, -2)
ANGULAR = (2, 0, 0)  # a weight of an angle's row in units of length: both errors weigh alike
UNITS: dict[str, tuple[int, int, int]] = {
    **dict.fromkeys(("foothold.reach", "foothold.spread", "foothold.separation", "standing.straddle"), L),
    **dict.fromkeys(("contact.zmp_margin", "contact.yaw_friction", "estimator.foot_height"), L),
    **dict.fromkeys(
        ("speed.integral_limit", "speed.largest_error", "speed.station_limit", "speed.settled_speed"), SPEED
    ),
    **dict.fromkeys(("standing.entry_speed", "standing.height_rate", "touchdown.descent_speed"), SPEED),
    **dict.fromkeys(("estimator.leg_odometry", "step_time.foot_speed"), SPEED),
    **dict.fromkeys(("speed.station_gain.0", "speed.station_gain.1", "joints.stop_rate", "standing.com_damping"), RATE),
    **dict.fromkeys(("tracking.joint_damping", "tracking.foot_damping", "other_joints.damping"), RATE),
    **dict.fromkeys((f"attitude.{axis}_damping" for axis in ("roll", "pitch", "yaw")), RATE),
    **dict.fromkeys((f"attitude.{axis}_stiffness" for axis in ("roll", "pitch", "yaw")), STIFFNESS),
    **dict.fromkeys(("tracking.joint_stiffness", "tracking.foot_stiffness", "standing.com_stiffness"), STIFFNESS),
    "other_joints.stiffness": STIFFNESS,
    "standing.longest_shift": T,
    **dict.fromkeys(("contact.normal_force.0", "contact.normal_force.1", "touchdown.force"), FORCE),
    "joints.torque_rate": (2, -3, 1),
    **dict.fromkeys(
        (f"weights.{name}" for name in ("stance_angular", "attitude", "yaw", "knee", "swing_joint", "swing_ankle")),
        ANGULAR,
    ),
    "weights.other_joint": ANGULAR,
    **dict.fromkeys(("weights.torque_change", "weights.regularisation"), TORQUES),
    "cop.weight": (-2, 0, -2),
}
FIXED = {  # of the paper, or of sensors
    *("foothold.velocity_gain.0", "foothold.velocity_gain.1", "inverse_kinematics.gain", "estimator.accelerometer"),
    *("estimator.accelerometer_drift", "estimator.joint_acceleration", "estimator.encoder"),
}


def numbers(value: Any, name: str = "") -> dict[str, float]:
    """Every number of nested data by its dotted name."""
    if isinstance(value, dict):
        return {
            key: number for part, entry in value.items() for key, number in numbers(entry, f"{name}.{part}").items()
        }
    if isinstance(value, (tuple, list)):
        return numbers(dict(enumerate(value)), name)
    return {name.lstrip("."): float(value)}


def in_own_units(scale: Scale) -> dict[str, float]:
    """The default set without units."""
    found = {}
    for name, value in numbers(default_parameters(scale)).items():
        length, time, mass = UNITS.get(name, (0, 0, 0))
        found[name] = value / (scale.height**length * scale.rate**-time * scale.mass**mass)
    return found


BASE = Scale(mass=18.0, gravity=9.81, height=0.33, half_width=0.045, edge=0.045, width=0.065)


@pytest.mark.parametrize("factor", [0.3, 2.0, 5.0])
@pytest.mark.parametrize("gravity", [1.62, 9.81])
@pytest.mark.parametrize("mass", [1.0, 7.0])
def test_a_scaled_robot_has_the_same_numbers(factor: float, gravity: float, mass: float) -> None:
    """Any length, mass and gravity."""
    lengths = {name: factor * getattr(BASE, name) for name in ("height", "half_width", "edge", "width")}
    scaled = replace(BASE, mass=mass * BASE.mass, gravity=gravity, **lengths)
    one, other = in_own_units(BASE), in_own_units(scaled)
    assert list(one) == list(other)
    for name, value in one.items():
        if name not in FIXED:
            assert other[name] == pytest.approx(value, rel=1e-12), name


def test_every_name_of_the_table_is_an_entry() -> None:
    assert set(UNITS) | FIXED <= set(numbers(default_parameters(BASE)))


@pytest.mark.parametrize("name", ROBOTS)
def test_units_of_a_robot(name: str) -> None:
    """Mass, gravity and height are the model's; ω² z = g."""
    scale = robot_scale(robot(name))
    assert scale.mass == pytest.approx(sum(robot(name).model.body_mass))
    assert scale.rate**2 * scale.height == pytest.approx(scale.gravity) == pytest.approx(9.81)
    assert scale.speed == pytest.approx(scale.rate * scale.height)
    assert scale.torque == pytest.approx(scale.mass * scale.gravity * scale.height)
    assert 0.5 * robot(name).card.gait.height < scale.height < 1.6 * robot(name).card.gait.height
    assert math.isfinite(scale.half_width)


def test_a_card_overrides_what_it_says_and_nothing_else() -> None:
    """BHR-B2's entries are the card's; those on which it is silent, and all of THBIP-II's, are the default's."""
    for name in ("bhr_b2", "thbip_ii"):
        card = numbers(robot(name).card.presets["default"].model_dump(exclude_none=True))
        default = numbers(default_parameters(robot_scale(robot(name))))
        for key, value in numbers(parameters(name).model_dump()).items():
            assert value == card.get(key, default.get(key)), key


def test_every_default_is_valid() -> None:
    for name in ROBOTS:
        ControlParameters.model_validate(default_parameters(robot_scale(robot(name))))


def test_an_unknown_preset_is_refused() -> None:
    with pytest.raises(BadInput, match="default, experiment, paper"):
        preset_parameters(robot("bhr_b2"), robot_scale(robot("bhr_b2")), "fast")
