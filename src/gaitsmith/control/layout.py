"""Order of the controller's arena: what a tick reads and writes, and where it stands in the table."""

from __future__ import annotations

from typing import NamedTuple

from gaitsmith.control.joint_torque import JointFeedback
from gaitsmith.control.state import ControlState, TickGains
from gaitsmith.control.telemetry import Telemetry
from gaitsmith.control.touchdown import TouchdownRule
from gaitsmith.dynamics.tree import Tree, TreeState
from gaitsmith.estimation.estimator import EstimatorGains, EstimatorState
from gaitsmith.estimation.measurement import Measurement
from gaitsmith.kinematics.inverse import InverseKinematics, LegKinematics
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.template.foothold import FootholdGains
from gaitsmith.template.step import Gait, StepState
from gaitsmith.whole_body.forward_dynamics import MotionMap
from gaitsmith.whole_body.frames import Frames, Legs
from gaitsmith.whole_body.solve import WholeBody
from gaitsmith.whole_body.targets import Targets, TaskGains


class TickGroups(NamedTuple):
    """All groups of the arena; the fields' order is the table's."""

    tree: Tree
    tree_state: TreeState
    legs: Legs
    frames: Frames
    requested: Gait
    latched: Gait
    step: StepState
    foothold: FootholdGains
    touchdown: TouchdownRule
    gains: TickGains
    task_gains: TaskGains
    targets: Targets
    motion: MotionMap
    whole_body: WholeBody
    program: QuadraticProgram
    feedback: JointFeedback
    left_chain: LegKinematics
    right_chain: LegKinematics
    left_inverse: InverseKinematics
    right_inverse: InverseKinematics
    left_program: QuadraticProgram
    right_program: QuadraticProgram
    measurement: Measurement
    control: ControlState
    estimator_gains: EstimatorGains
    estimator: EstimatorState
    telemetry: Telemetry
