"""Order of the controller's arena: what a tick reads and writes, and where it stands in the table."""

from __future__ import annotations

from typing import NamedTuple

from gaitsmith.control.estimation import EstimatorGains, EstimatorState
from gaitsmith.control.frames import Frames, Legs
from gaitsmith.control.inverse_kinematics import InverseKinematics, LegKinematics
from gaitsmith.control.joint_torque import JointFeedback
from gaitsmith.control.measurement import Measurement
from gaitsmith.control.motion_map import MotionMap
from gaitsmith.control.quadratic_program import QuadraticProgram
from gaitsmith.control.state import ControlState, TickGains
from gaitsmith.control.targets import Targets, TaskGains
from gaitsmith.control.telemetry import Telemetry
from gaitsmith.control.touchdown import TouchdownRule
from gaitsmith.control.whole_body import WholeBody
from gaitsmith.dynamics.tree import Tree, TreeState
from gaitsmith.template.foothold import FootholdGains
from gaitsmith.template.step import Gait, StepState


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


_CLASSES: tuple[type, ...] = (
    Tree,
    TreeState,
    Legs,
    Frames,
    Gait,
    Gait,
    StepState,
    FootholdGains,
    TouchdownRule,
    TickGains,
    TaskGains,
    Targets,
    MotionMap,
    WholeBody,
    QuadraticProgram,
    JointFeedback,
    LegKinematics,
    LegKinematics,
    InverseKinematics,
    InverseKinematics,
    QuadraticProgram,
    QuadraticProgram,
    Measurement,
    ControlState,
    EstimatorGains,
    EstimatorState,
    Telemetry,
)
_SIZES = [len(cls.__annotations__) for cls in _CLASSES]
_FIRST = tuple(sum(_SIZES[:k]) for k in range(len(_CLASSES)))
(
    TREE,
    TREE_STATE,
    LEGS,
    FRAMES,
    REQUESTED,
    LATCHED,
    STEP,
    FOOTHOLD,
    TOUCHDOWN,
    GAINS,
    TASK_GAINS,
    TARGETS,
    MOTION,
    WHOLE_BODY,
    PROGRAM,
    FEEDBACK,
    LEFT_CHAIN,
    RIGHT_CHAIN,
    LEFT_INVERSE,
    RIGHT_INVERSE,
    LEFT_PROGRAM,
    RIGHT_PROGRAM,
    MEASUREMENT,
    CONTROL,
    ESTIMATOR_GAINS,
    ESTIMATOR,
    TELEMETRY,
) = _FIRST
