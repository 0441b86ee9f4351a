"""State of the gait template: the requested and the latched gait, and the step being taken."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import IntVector, Matrix, Vector

if TYPE_CHECKING:
    from gaitsmith.robots.parameters import GaitParameters

STAND = 0
WALK = 1
LEFT = 0
RIGHT = 1


class Gait(NamedTuple):
    """Gait parameters as a kernel reads them; one-element vectors are scalars that may change.

    Attributes:
        speed: (2,) forward and lateral CoM velocity in the heading frame, m/s.
        period: T, s.
        alpha: lifting share of the period.
        height: H, hip midpoint above the stance sole, m.
        lift: h, m.
        width: W, half the sole distance, m.
    """

    speed: Vector
    period: Vector
    alpha: Vector
    height: Vector
    lift: Vector
    width: Vector


class StepState(NamedTuple):
    """The step being taken. Positions are soles relative to the hip midpoint, heading frame.

    Attributes:
        mode: (1,) STAND or WALK.
        walk_requested: (1,) 1 to walk, 0 to come to rest.
        stance: (1,) LEFT or RIGHT; in STAND the leg that bore the last step.
        count: (1,) steps taken since the reset.
        time: (1,) time since the step began, s.
        last_duration: (1,) duration of the previous step, s.
        duration_ratio: (1,) how long steps last, as a share of the commanded period (early touchdown).
        support_start: (3, 3) desired position, velocity, acceleration of the support sole when the step began.
        swing_start: (2, 3) actual position and velocity of the swing sole when the step began.
        swing_pitch_start: (1,) pitch of the swing sole when the step began, rad.
        velocity_sum: (2,) sum of the CoM velocity over the ticks of this step, m/s.
        velocity_ticks: (1,) number of those ticks.
        last_mean_velocity: (2,) mean CoM velocity of the previous step, m/s.
        settling: (1,) steps to go before the integral learns again; a new speed is no bias.
        integral: (2,) bias integral of the foothold, m.
        station: (2,) horizontal position to keep while the commanded speed is zero, world, m.
        station_kept: (1,) 1 once ``station`` is set.
        last_position: (2,) mean CoM position of the previous step, world, m.
        position_sum: (2,) sum of the CoM position over the ticks of this step, world, m.
    """

    mode: IntVector
    walk_requested: IntVector
    stance: IntVector
    count: IntVector  # type: ignore[assignment]
    time: Vector
    last_duration: Vector
    duration_ratio: Vector
    support_start: Matrix
    swing_start: Matrix
    swing_pitch_start: Vector
    velocity_sum: Vector
    velocity_ticks: IntVector
    last_mean_velocity: Vector
    settling: IntVector
    integral: Vector
    station: Vector
    station_kept: IntVector
    last_position: Vector
    position_sum: Vector


def make_gait(parameters: GaitParameters) -> Gait:
    """Kernel form of ``parameters``."""
    scalars = (parameters.period, parameters.alpha, parameters.height, parameters.lift, parameters.width)
    return Gait(np.array(parameters.speed), *(np.array([value]) for value in scalars))


def make_step_state() -> StepState:
    """State of a robot at rest on both feet."""

    def integer() -> npt.NDArray[np.int64]:
        return np.zeros(1, dtype=np.int64)

    return StepState(
        mode=integer(),
        walk_requested=integer(),
        stance=integer(),
        count=integer(),
        time=np.zeros(1),
        last_duration=np.zeros(1),
        duration_ratio=np.ones(1),
        support_start=np.zeros((3, 3)),
        swing_start=np.zeros((2, 3)),
        swing_pitch_start=np.zeros(1),
        velocity_sum=np.zeros(2),
        velocity_ticks=integer(),
        last_mean_velocity=np.zeros(2),
        settling=integer(),
        integral=np.zeros(2),
        station=np.zeros(2),
        station_kept=integer(),
        last_position=np.zeros(2),
        position_sum=np.zeros(2),
    )
