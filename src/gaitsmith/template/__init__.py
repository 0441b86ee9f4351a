"""Gait template: leg trajectories, event-triggered switching, foothold adjustment (Han 2023, sections 2 and 3.1)."""

from gaitsmith.template.step import GaitInputs as GaitInputs
from gaitsmith.template.step import StepState as StepState
