"""What a card does not say: the model's own numbers, or numbers that scale with the robot."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from tests.robots.samples import BHR, MODELS, bhr_text, build, build_model, card_data, changed

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot

SHORT = ("limits", "gait", "gait_limits", "mass", "presets", "assumptions")


def short(path: Path = BHR / "card.toml") -> dict[str, Any]:
    return {key: value for key, value in tomllib.loads(path.read_text()).items() if key not in SHORT}


def test_a_short_card_has_the_models_limits_and_mass() -> None:
    robot, whole = build(short()), load_robot("bhr_b2")
    assert robot.mass == robot.card.mass == whole.mass
    for name in ("position_low", "position_high", "torque_limit"):
        assert getattr(robot, name).tolist() == getattr(whole, name).tolist()
    assert [note for note in robot.notes if "assumed" in note and "velocity limit" in note and "every joint" in note]


def test_what_is_assumed_scales_with_the_robot(tmp_path: Path) -> None:
    import benchmarks.scaled as scaled

    factor = 3.0
    path = scaled.write_scaled("thbip_ii", factor, tmp_path)
    small = build(short(BHR.parent / "thbip_ii" / "card.toml"), BHR.parent / "thbip_ii")
    large = build(short(path), tmp_path)
    powers = {"period": 0.5, "height": 1.0, "lift": 1.0, "width": 1.0, "alpha": 0.0}
    for name, power in powers.items():
        value = getattr(small.card.gait, name) * factor**power
        assert getattr(large.card.gait, name) == pytest.approx(value)
        bounds = [bound * factor**power for bound in getattr(small.card.gait_limits, name)]
        assert getattr(large.card.gait_limits, name) == pytest.approx(bounds)
    assert large.velocity_limit == pytest.approx(small.velocity_limit * factor**-0.5)
    for name, power in (("speed_x", 0.5), ("speed_y", 0.5), ("yaw_rate", -0.5)):
        bounds = [bound * factor**power for bound in getattr(small.card.gait_limits, name)]
        assert getattr(large.card.gait_limits, name) == pytest.approx(bounds)


def test_legs_that_cannot_turn_are_not_told_to() -> None:
    assert build(short()).card.gait_limits.yaw_rate == (0.0, 0.0)
    low, high = build(short(MODELS / "with_arms.toml"), MODELS).card.gait_limits.yaw_rate
    assert low < 0.0 < high


def test_a_gait_that_the_card_gives_widens_what_is_assumed_for_it() -> None:
    robot = build(short() | {"gait": {"period": 0.9}})
    assert robot.card.gait.period == robot.card.gait_limits.period[1] == 0.9
    narrow = build(short() | {"gait_limits": {"period": [0.2, 0.3]}})
    assert narrow.card.gait.period == 0.3


def test_longer_steps_than_any_gait_survives_are_said() -> None:
    long = changed(card_data(), "gait_limits", "period", value=[0.2, 1.0])
    assert [note for note in build(long).notes if "no steps longer than" in note]
    assert not [note for note in build(card_data()).notes if "no steps longer than" in note]


@pytest.mark.parametrize(("entry", "narrow", "wide"), [("torque", 100.0, 300.0), ("position", [0.1, 2.0], [-1.0, 2.6])])
def test_limits_may_be_narrowed_and_not_widened(entry: str, narrow: Any, wide: Any) -> None:
    card = short() | {"limits": {"left_knee": {entry: narrow}}}
    assert build(card).card.limits["left_knee"].model_dump(mode="json")[entry] == narrow
    card["limits"]["left_knee"] = {entry: wide}
    with pytest.raises(BadInput, match=rf"limits\.left_knee\.{entry}: .*trust"):
        build(card)
    trusted = build(card | {"trust": "card"}).card.limits["left_knee"]
    assert trusted.model_dump(mode="json")[entry] == wide


def test_torques_that_limit_nothing_are_said(tmp_path: Path) -> None:
    text = bhr_text().replace('ctrlrange="-200 200"', 'ctrlrange="-2000 2000"')
    robot = build_model(text, tmp_path, short())
    assert robot.card.limits["left_knee"].torque == 2000.0
    assert [note for note in robot.notes if "placeholders" in note and "left_knee" in note]


def test_the_home_posture_is_the_robots(tmp_path: Path) -> None:
    path = MODELS / "with_arms.toml"
    robot = build(short(path) | {"home": {"left_elbow": -0.5}}, MODELS)
    assert robot.home[robot.joint_names.index("left_elbow")] == -0.5
    assert robot.home[robot.joint_names.index("right_elbow")] == -1.25  # 0 is its stop
    assert any("held at" in note and "right_elbow -1.25" in note and "left_elbow" not in note for note in robot.notes)
    welded = build(short(path) | {"weld": ["right_elbow"], "home": {"right_elbow": -0.3}}, MODELS)
    assert "right_elbow" not in welded.joint_names
    assert welded.mass == robot.mass
