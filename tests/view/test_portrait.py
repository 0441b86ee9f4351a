"""A portrait shows every joint in its role's colour, both soles, and the names of one leg."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gaitsmith.adoption.picture import portrait_of
from gaitsmith.robots import load_robot
from gaitsmith.view import save
from gaitsmith.view.portrait import draw_portrait


def test_joints_soles_and_names_are_drawn(tmp_path: Path) -> None:
    robot = load_robot("thbip_ii")
    portrait = portrait_of(robot)
    assert {joint.role for joint in portrait.joints} == {"roll", "pitch", "yaw"}
    assert [joint.name for joint in portrait.joints] == list(robot.joint_names)
    assert np.abs(np.vstack(portrait.soles)[:, 2]).max() < 1e-6
    assert 0.0 < portrait.com[2] < robot.card.gait.height
    made = draw_portrait(portrait)
    written = {text.get_text() for axes in made.axes for text in axes.texts}
    assert {text.partition(" (")[0] for text in written} == set(robot.legs[0].joints)
    assert save(made, tmp_path / "robot.png").stat().st_size > 10_000
