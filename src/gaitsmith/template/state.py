"""All that the template reads and writes, as one view."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector
from gaitsmith.kinematics.inverse import InverseGains, InverseKinematics, LegTable
from gaitsmith.qp.quadratic_program import QuadraticProgram
from gaitsmith.template.balance import CopGains
from gaitsmith.template.foothold import FootholdGains, Forecast, SpeedGains
from gaitsmith.template.ground import Ground
from gaitsmith.template.posture import Posture
from gaitsmith.template.step import GaitInputs, StepState
from gaitsmith.template.touchdown import TouchdownRule
from gaitsmith.template.trajectory import Printed
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.reference import Reference


class RestGains(NamedTuple):
    """When a walk begins and ends.

    Attributes:
        weight_shift: 1 to shift the weight over the first stance foot before lifting the other, 0 to lift at once.
        longest_shift: s after which the first step is taken anyway.
        entry_speed: largest CoM speed at which a walk may end in standing, m/s.
        straddle: forward distance of the soles up to which it may, m.
        height_rate: how fast the hips follow a new height while standing, m/s.
    """

    weight_shift: float
    longest_shift: float
    entry_speed: float
    straddle: float
    height_rate: float


class StepTimeGains(NamedTuple):
    """:class:`StepTimeParameters` as a kernel reads them."""

    shortest: float
    foot_speed: float


class JointShares(NamedTuple):
    """Weights of the legs' joints while walking: stance knee, swing joints, swing ankle, 1/(rad/s²)²."""

    knee: float
    swing_joint: float
    swing_ankle: float


class Balance(NamedTuple):
    """Scratch of the balance; heading frame.

    Attributes:
        divergent: (2,) reference of the divergent component, relative to the stance sole, m.
        cop: (2,) wanted centre of pressure, relative to the stance sole, m.
        foot: (2,) swing sole relative to the CoM, m.
        curve: (3,) one coordinate, its rate and acceleration.
        position: (3,) a sole in the torso frame, m.
        velocity: (3,) its velocity, m/s.
        rotation: (3, 3) sole to torso.
    """

    divergent: Vector
    cop: Vector
    foot: Vector
    curve: Vector
    position: Vector
    velocity: Vector
    rotation: Matrix


def make_balance() -> Balance:
    """Scratch of zeros."""
    pairs, triples = [np.zeros(2) for _ in range(3)], [np.zeros(3) for _ in range(3)]
    return Balance(*pairs, *triples, np.zeros((3, 3)))  # type: ignore[call-arg]


class Template(NamedTuple):
    """What the kernels of the template share.

    Attributes:
        body: the robot as this tick sees it.
        reference: that the template writes.
        sole_force: (n,) measured normal force on every sole, N.
        acceleration: (nv,) that the last whole-body solution predicted.
        turns: (1,) 1 if the legs can turn the torso about the vertical.
        requested: gait inputs as last commanded.
        latched: those of the step being taken.
        step: the step being taken.
        ground: what is known of it.
        posture: of the joints outside the legs.
        inverse_program: of the inverse kinematics.
    """

    body: Body
    reference: Reference
    sole_force: Vector
    acceleration: Vector
    turns: IntVector
    requested: GaitInputs
    latched: GaitInputs
    step: StepState
    ground: Ground
    posture: Posture
    foothold: FootholdGains
    speed: SpeedGains
    times: StepTimeGains
    printed: Printed
    cop: CopGains
    shares: JointShares
    forecast: Forecast
    balance: Balance
    touchdown: TouchdownRule
    rest: RestGains
    chains: LegTable
    inverse_gains: InverseGains
    inverse: InverseKinematics
    inverse_program: QuadraticProgram
