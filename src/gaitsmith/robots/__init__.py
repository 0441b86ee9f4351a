"""Robots: cards, models, and loading both with everything checked."""

from gaitsmith.robots.card import RobotCard as RobotCard
from gaitsmith.robots.loading import load_robot as load_robot
from gaitsmith.robots.loading import robot_names as robot_names
from gaitsmith.robots.robot import Leg as Leg
from gaitsmith.robots.robot import Robot as Robot
from gaitsmith.robots.robot import describe as describe
