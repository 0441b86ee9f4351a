"""Spline-parametric gait synthesis: motions as data, one constrained optimisation, and a certificate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gaitsmith.lazy import lazily

if TYPE_CHECKING:
    from gaitsmith.synthesis.files.gait_file import load_robot_of as load_robot_of
    from gaitsmith.synthesis.files.gait_file import read_gait as read_gait
    from gaitsmith.synthesis.files.gait_file import write_gait as write_gait
    from gaitsmith.synthesis.gaits.gait import Gait as Gait
    from gaitsmith.synthesis.motions.motion import Motion as Motion
    from gaitsmith.synthesis.motions.motion import Phase as Phase
    from gaitsmith.synthesis.motions.parameters import KickParameters as KickParameters
    from gaitsmith.synthesis.motions.parameters import StepParameters as StepParameters
    from gaitsmith.synthesis.motions.settings import Bounds as Bounds
    from gaitsmith.synthesis.motions.settings import Settings as Settings
    from gaitsmith.synthesis.proof.verify import verify as verify
    from gaitsmith.synthesis.requests.asked import Request as Request
    from gaitsmith.synthesis.requests.request import answer as answer
    from gaitsmith.synthesis.requests.request import answer_file as answer_file
    from gaitsmith.synthesis.requests.summary import plan_document as plan_document
    from gaitsmith.synthesis.solution.plan import Planner as Planner
    from gaitsmith.synthesis.solution.plan import PlanResult as PlanResult

__getattr__, __dir__ = lazily(__name__)
