"""Spline-parametric gait synthesis: motions as data, one constrained optimisation, and a certificate."""

from gaitsmith.synthesis.gait import Gait as Gait
from gaitsmith.synthesis.gait_file import load_robot_of as load_robot_of
from gaitsmith.synthesis.gait_file import read_gait as read_gait
from gaitsmith.synthesis.gait_file import write_gait as write_gait
from gaitsmith.synthesis.motion import Motion as Motion
from gaitsmith.synthesis.motion import Phase as Phase
from gaitsmith.synthesis.motions import KickParameters as KickParameters
from gaitsmith.synthesis.motions import StepParameters as StepParameters
from gaitsmith.synthesis.plan import Planner as Planner
from gaitsmith.synthesis.plan import PlanResult as PlanResult
from gaitsmith.synthesis.request import Request as Request
from gaitsmith.synthesis.request import answer as answer
from gaitsmith.synthesis.settings import Bounds as Bounds
from gaitsmith.synthesis.settings import Settings as Settings
from gaitsmith.synthesis.summary import plan_document as plan_document
from gaitsmith.synthesis.verify import verify as verify
