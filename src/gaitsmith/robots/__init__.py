"""Robots: cards, models, and loading both with everything checked. Names load on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gaitsmith.lazy import lazily

if TYPE_CHECKING:
    from gaitsmith.robots.card import RobotCard as RobotCard
    from gaitsmith.robots.loading import load_robot as load_robot
    from gaitsmith.robots.loading import robot_names as robot_names
    from gaitsmith.robots.model_file import open_model as open_model
    from gaitsmith.robots.robot import Leg as Leg
    from gaitsmith.robots.robot import Robot as Robot
    from gaitsmith.robots.robot import describe as describe

__getattr__, __dir__ = lazily(__name__)
