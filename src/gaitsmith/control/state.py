"""Memory of the controller between ticks, and what its kernels read, as one typed view."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Vector
from gaitsmith.control.joint_torque import JointFeedback
from gaitsmith.control.telemetry import Telemetry
from gaitsmith.estimation.estimator import Estimation
from gaitsmith.estimation.measurement import Measurement
from gaitsmith.estimation.motors import Motors
from gaitsmith.estimation.readings import Checking
from gaitsmith.planned.law import Following
from gaitsmith.planned.replay import ReplayGains
from gaitsmith.template.state import Template
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.problem import WholeBody
from gaitsmith.whole_body.reference import Reference
from gaitsmith.whole_body.tasks import TaskTable

OFF, DAMPING, STANDING, WALKING, FAULT, AIRBORNE, FOLLOWING = range(7)
"""Control states: no torque; joints braked; on both feet; walking; braked, as something is lost; lifted off; a plan."""

STATE_NAMES = ("off", "damping", "standing", "walking", "fault", "airborne", "following")


class ControlState(NamedTuple):
    """What one tick leaves for the next.

    Attributes:
        time: (1,) since the reset, s.
        state: (1,) control state, one of :data:`STATE_NAMES`.
        asked: (1,) OFF, DAMPING or FOLLOWING if asked for, FAULT if something is lost that the robot cannot do without,
            until told to stand or walk; else STANDING: the template decides.
        replays: (1,) 1 if a plan is replayed by the joints alone.
        torque: (nj,) last torque sent, N·m.
        wanted: (nj,) torque of a tick before it is bounded, N·m.
        held: (nj,) joint angles in which the robot last stood on the ground, held in the air, rad.
        refused: (8,) ticks in which readings of each sensor were replaced, in the order of :class:`Measurement`.
        refused_ticks: (1,) ticks with any.
        missed: (1,) ticks that came too late to be done.
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
    torque: Vector
    wanted: Vector
    held: Vector
    refused: IntVector
    refused_ticks: IntVector
    missed: IntVector
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
    """Everything that a tick reads and writes: ``g.template.step.time`` inside a kernel."""

    body: Body
    reference: Reference
    template: Template
    whole_body: WholeBody
    tasks: TaskTable
    following_tasks: TaskTable
    following: Following
    replay: ReplayGains
    feedback: JointFeedback
    gains: TickGains
    measurement: Measurement
    checking: Checking
    motors: Motors
    control: ControlState
    estimation: Estimation
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
        torque=np.zeros(n_joints),
        wanted=np.zeros(n_joints),
        held=np.zeros(n_joints),
        refused=np.zeros(len(Measurement._fields), dtype=np.int64),
        refused_ticks=whole(),
        missed=whole(),
        estimated=whole(int(estimated)),
        sent=whole(),
        unloaded=np.zeros(1),
        turns=whole(int(turns)),
        mailbox=np.zeros(n_inputs),
        letters=whole(),
        read=whole(),
    )
