from __future__ import annotations

import math
import re
from typing import Any

import pytest
from pydantic import ValidationError
from tests.robots.samples import MODELS, build, card_data, changed

from gaitsmith.errors import BadInput
from gaitsmith.robots.card_file import parse_card

DATA = card_data()


def test_shipped_card_says_what_the_paper_says() -> None:
    card = parse_card(DATA)
    gait = card.gait
    assert (gait.period, gait.alpha, gait.height, gait.lift, gait.width) == (0.4, 0.5, 0.7, 0.1, 0.0375)
    for leg in card.legs:
        assert (leg.sole.kind, leg.sole.heel, leg.sole.toe, leg.sole.half_width) == ("line", 0.07, 0.12, 0.0)
    assert any("40.3" in assumption.why for assumption in card.assumptions)


def test_presets_are_merged_over_the_default() -> None:
    presets = parse_card(DATA).presets
    default, paper = presets["default"], presets["paper"]
    assert paper.speed.integral_gain == (0.0, 0.0)
    assert paper.foothold.sway == default.foothold.sway
    assert paper.joint_gains.swing_stiffness == (60.0, 150.0, 150.0, 30.0)
    assert paper.tracking == default.tracking


def test_a_card_may_be_silent() -> None:
    """Presets, and any of their entries, follow from the robot's size and mass; only the default is always there."""
    card = parse_card(changed(DATA, "presets", value=...))
    assert list(card.presets) == ["default"]
    assert card.presets["default"].model_dump(exclude_none=True) == {}
    presets = parse_card(changed(DATA, "presets", "default", value=...)).presets
    assert list(presets) == ["default", "paper", "experiment"]
    assert presets["paper"].foothold.sway is None


def test_card_is_frozen() -> None:
    card = parse_card(DATA)
    with pytest.raises(ValidationError):
        card.mass = 1.0  # type: ignore[misc]


LEG = DATA["legs"][0]
CASES: list[tuple[tuple[str | int, ...], Any, str]] = [
    (("legs", 0, "sole", "toe"), -0.1, "legs[0].sole.toe"),
    (("legs", 0, "sole", "toe"), math.nan, "legs[0].sole.toe"),
    (("legs", 0, "sole", "toe"), ..., "legs[0].sole.toe"),
    (("legs", 0, "sole", "toe"), "0.1", "legs[0].sole.toe"),
    (("legs", 0, "sole", "half_width"), 0.02, "legs[0].sole.half_width"),
    (("legs", 0, "sole", "kind"), "disc", "legs[0].sole.kind"),
    (("legs", 0, "sole", "kind"), "rectangle", "legs[0].sole.half_width"),
    (("legs", 1, "name"), "left", "legs"),
    (("legs", 1, "joints"), LEG["joints"], "legs[1].knee"),
    (("legs", 0, "joints", 1), "left_hip_roll", "legs[0].joints"),
    (("legs", 0, "joints", 1), "no_such_joint", "legs[0].joints[1]"),
    (("legs", 0, "joints"), LEG["joints"][1:], "legs[1].joints"),
    (("legs", 0, "joints"), LEG["joints"][::-1], "legs[0].knee|legs[0].ankle_pitch"),
    (("legs", 0, "knee"), "left_hip_roll", "legs[0].knee"),
    (("legs", 0, "ankle_pitch"), "left_hip_pitch", "legs[0].ankle_pitch"),
    (("legs", 0, "ankle_roll"), "left_ankle", "legs[0].ankle_roll"),
    (("legs", 0, "sole_site"), "nowhere", "legs[0].sole_site"),
    (("legs", 0, "sole_site"), ..., "legs[0].sole_site"),
    (("legs", 0, "sole_body"), "left_foot", "legs[0].sole_site"),
    (("legs",), DATA["legs"][:1], "legs[1]"),
    (("limits", "left_knee", "torque"), 300.0, "limits.left_knee.torque"),
    (("home",), {"left_knee": 0.3}, "home"),
    (("weld",), ["left_knee"], "weld"),
    (("trust",), "me", "trust"),
    (("limits", "left_knee", "position"), [1.0, 0.5], "limits.left_knee.position"),
    (("limits", "left_knee", "position"), [-1.0, 2.0], "limits.left_knee.position"),
    (("limits", "left_knee", "torque"), 0, "limits.left_knee.torque"),
    (("limits", "left_knee", "velocity"), math.inf, "limits.left_knee.velocity"),
    (("limits", "third_knee"), DATA["limits"]["left_knee"], "limits.third_knee"),
    (("mass",), -39.9, "mass"),
    (("mass",), 40.3, "mass"),
    (("mass",), True, "mass"),
    (("torso",), "head", "torso"),
    (("torso",), "left_foot", "imu_site"),
    (("imu_site",), "left_sole", "imu_site"),
    (("imu_site",), "", "imu_site"),
    (("model",), "none.xml", "model"),
    (("model",), "card.toml", "card.toml"),
    (("schema_version",), 3, "schema_version"),
    (("colour",), "red", "colour"),
    (("gait", "height"), 0.8, "gait.height"),
    (("gait", "period"), -0.4, "gait.period"),
    (("gait", "period"), 40.0, "gait.period"),
    (("gait", "speed"), [9.0, 0.0], "gait.speed[0]"),
    (("gait_limits", "height"), [0.42, 0.77], "gait_limits.height[1]"),
    (("gait_limits", "alpha"), [0.8, 0.2], "gait_limits.alpha"),
    (("gait_limits", "yaw_rate"), [-0.5, 0.5], "gait_limits.yaw_rate"),
    (("gait", "yaw_rate"), 0.1, "gait.yaw_rate"),
    (("presets",), [], "presets"),
    (("presets", "default", "contact", "normal_force"), [20.0, 10.0], "presets.default.contact.normal_force"),
    (("presets", "paper", "joint_gains", "swing_damping"), [1.0], "presets.paper.joint_gains.swing_damping"),
    (("presets", "default", "foothold", "separation"), 0.9, "presets.default.foothold.separation"),
    (("presets", "paper", "foothold", "reach"), -1, "presets.paper.foothold.reach"),
    (("presets", "paper", "foothold"), "none", "presets.paper.foothold"),
]


@pytest.mark.parametrize(("path", "value", "named"), CASES)
def test_errors_name_the_entry_in_one_line(path: tuple[str | int, ...], value: Any, named: str) -> None:
    with pytest.raises(BadInput) as caught:
        build(changed(DATA, *path, value=value))
    fields = [field if ":" in field or field == "card.toml" else f"card.toml: {field}" for field in named.split("|")]
    assert caught.value.field in fields
    assert re.fullmatch(r"[^\n]+: got .+, expected .+", str(caught.value))


def test_legs_share_no_joint() -> None:
    data = changed(DATA, "legs", 1, value=DATA["legs"][0] | {"name": "right"})
    with pytest.raises(BadInput, match=r"legs\[1\].joints"):
        parse_card(data)


def test_all_model_cards_are_valid() -> None:
    for path in MODELS.glob("*.toml"):
        assert parse_card(card_data(path)).name == path.stem
