"""Memory of the controller between ticks, and what its kernels read, as one typed view."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Vector
from gaitsmith.control.joint_torque import JointFeedback
from gaitsmith.control.telemetry import Telemetry
from gaitsmith.dynamics.tree import Tree, TreeState
from gaitsmith.estimation.estimator import EstimatorGains, EstimatorState
from gaitsmith.estimation.measurement import Measurement
from gaitsmith.kinematics.inverse import InverseGains, InverseKinematics, LegTable
from gaitsmith.planned.law import Following
from gaitsmith.planned.replay import ReplayGains
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.template.balance import CopGains
from gaitsmith.template.foothold import FootholdGains, Forecast, SpeedGains
from gaitsmith.template.phase import RestGains
from gaitsmith.template.step import GaitInputs, StepState
from gaitsmith.template.step_time import StepTimeGains
from gaitsmith.template.touchdown import TouchdownRule
from gaitsmith.template.walking import Balance, JointShares
from gaitsmith.whole_body.contact import ContactBounds, Contacts
from gaitsmith.whole_body.forward_dynamics import MotionMap
from gaitsmith.whole_body.frames import Frames
from gaitsmith.whole_body.legs import Legs
from gaitsmith.whole_body.reference import Reference
from gaitsmith.whole_body.solve import JointBounds, WholeBody
from gaitsmith.whole_body.tasks import TaskTable

OFF, DAMPING, STANDING, WALKING, FAULT, AIRBORNE, FOLLOWING = range(7)
"""Control states: no torque; joints braked; on both feet; walking; unusable readings; lifted off; following a plan."""

STATE_NAMES = ("off", "damping", "standing", "walking", "fault", "airborne", "following")


class ControlState(NamedTuple):
    """What one tick leaves for the next.

    Attributes:
        time: (1,) since the reset, s.
        state: (1,) control state, one of :data:`STATE_NAMES`.
        asked: (1,) OFF, DAMPING or FOLLOWING if asked for, else STANDING: the template decides.
        replays: (1,) 1 if a plan is replayed by the joints alone.
        q: (7 + nj,) true or estimated configuration.
        v: (6 + nj,) true or estimated velocity.
        torque: (nj,) last torque sent, N·m.
        held: (nj,) joint angles in which the robot last stood on the ground, held in the air, rad.
        refused: (8,) ticks refused for the readings of each sensor, in the order of :class:`Measurement`.
        refused_ticks: (1,) ticks refused.
        estimated: (1,) 1 if the state is estimated from sensors.
        sent: (1,) 1 once a torque has been sent: its change is bounded from then on.
        unloaded: (1,) for how long no sole has borne anything, s.
        turns: (1,) 1 if the legs can turn the torso about the vertical.
        mailbox: gait inputs as last commanded; taken over when ``letters`` is even.
        letters: (1,) odd while the mailbox is being written.
        read: (1,) ``letters`` of what was taken over last.
    """

    time: Vector
    state: IntVector
    asked: IntVector
    replays: IntVector
    q: Vector
    v: Vector
    torque: Vector
    held: Vector
    refused: IntVector
    refused_ticks: IntVector
    estimated: IntVector
    sent: IntVector
    unloaded: Vector
    turns: IntVector
    mailbox: Vector
    letters: IntVector
    read: IntVector


class TickGains(NamedTuple):
    """Scalars that belong to no single task.

    Attributes:
        dt: control period, s.
        brake: torque per joint speed in the damping state, in units of the joint's torque limit per rad/s.
        hold: angle error at which a held joint uses its whole torque, rad.
        contact_force: sole force that counts as contact, N.
    """

    dt: float
    brake: float
    hold: float
    contact_force: float


class Tick(NamedTuple):
    """Everything that a tick reads and writes: ``g.step.time`` inside a kernel."""

    tree: Tree
    tree_state: TreeState
    legs: Legs
    frames: Frames
    requested: GaitInputs
    latched: GaitInputs
    step: StepState
    foothold: FootholdGains
    speed: SpeedGains
    times: StepTimeGains
    cop: CopGains
    shares: JointShares
    forecast: Forecast
    balance: Balance
    touchdown: TouchdownRule
    rest: RestGains
    gains: TickGains
    reference: Reference
    tasks: TaskTable
    contacts: Contacts
    contact_bounds: ContactBounds
    joint_bounds: JointBounds
    motion: MotionMap
    body: WholeBody
    program: QuadraticProgram
    feedback: JointFeedback
    chains: LegTable
    inverse_gains: InverseGains
    inverse: InverseKinematics
    inverse_program: QuadraticProgram
    following: Following
    following_tasks: TaskTable
    replay: ReplayGains
    measurement: Measurement
    control: ControlState
    estimator_gains: EstimatorGains
    estimator: EstimatorState
    telemetry: Telemetry


def make_control_state(n_joints: int, estimated: bool, turns: bool, n_inputs: int) -> ControlState:
    """Memory of a controller that has not ticked yet."""

    def whole(value: int = 0) -> IntVector:
        return np.array([value], dtype=np.int64)

    return ControlState(
        time=np.zeros(1),
        state=whole(STANDING),
        asked=whole(STANDING),
        replays=whole(),
        q=np.zeros(7 + n_joints),
        v=np.zeros(6 + n_joints),
        torque=np.zeros(n_joints),
        held=np.zeros(n_joints),
        refused=np.zeros(len(Measurement._fields), dtype=np.int64),
        refused_ticks=whole(),
        estimated=whole(int(estimated)),
        sent=whole(),
        unloaded=np.zeros(1),
        turns=whole(int(turns)),
        mailbox=np.zeros(n_inputs),
        letters=whole(),
        read=whole(),
    )
