"""State of the gait template: the requested and the latched gait inputs, and the step being taken."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntVector, Matrix, Vector

if TYPE_CHECKING:
    from gaitsmith.robots.parameters import GaitParameters

STAND, SHIFT, WALK = 0, 1, 2
"""On both feet; shifting the weight before the first step; walking."""


class GaitInputs(NamedTuple):
    """Gait parameters as a kernel reads them: views of one buffer, so that all are taken over at once.

    Attributes:
        speed: (2,) forward and lateral CoM velocity in the heading frame, m/s.
        period: (1,) T, s.
        alpha: (1,) lifting share of the period.
        height: (1,) H, hip midpoint above the stance sole, m.
        lift: (1,) h, m.
        width: (1,) W, half the sole distance, m.
        yaw_rate: (1,) rad/s.
        values: all of them in one array.
    """

    speed: Vector
    period: Vector
    alpha: Vector
    height: Vector
    lift: Vector
    width: Vector
    yaw_rate: Vector
    values: Vector


class StepState(NamedTuple):
    """The step being taken. Positions are soles relative to the hip midpoint, heading frame.

    Attributes:
        mode: (1,) STAND, SHIFT or WALK.
        walk_requested: (1,) 1 to walk, 0 to come to rest.
        stance: (1,) row of the stance leg; in STAND the leg that bore the last step.
        count: (1,) steps taken since the reset.
        forced: (1,) steps ended by the clock instead of by contact.
        time: (1,) since the step, or the shift, began, s.
        period: (1,) duration that this step is taken for, s; at most the latched period.
        place: (1,) time along the nominal curves, s: the period when the step ends, later than that past its end.
        rate: (1,) how fast ``place`` advances.
        last_duration: (1,) duration of the previous step, s.
        duration_ratio: (1,) how long steps last, as a share of the commanded period (early touchdown).
        support_start: (3, 3) desired position, velocity, acceleration (rows) of the support sole when the step began.
        swing_start: (2, 3) actual position and velocity of the swing sole when the step began.
        swing_pitch_start: (1,) pitch of the swing sole when the step began, rad.
        swing_yaw_start: (1,) its yaw against the heading, rad.
        heading: (1,) yaw that the torso is to have, world, rad.
        heading_set: (1,) 1 once ``heading`` is set.
        velocity_sum: (2,) sum of the CoM velocity over the ticks of this step, m/s.
        velocity_ticks: (1,) number of those ticks.
        last_mean_velocity: (2,) mean CoM velocity of the previous step, m/s.
        stride_mean: (2,) mean CoM velocity of the previous stride, m/s.
        settling: (1,) steps to go before the integral learns again; a new speed is no bias.
        integral: (2,) what is added to the commanded speed so that the mean speed is the commanded one, m/s.
        learnt: (2,) what the last step added to it, m/s.
        speed: (2,) the speed that the step is taken for: command, integral and station keeping, m/s.
        station: (2,) horizontal position to keep while the commanded speed is zero, world, m.
        station_kept: (1,) 1 once ``station`` is set.
        last_position: (2,) mean CoM position of the previous step, world, m.
        position_sum: (2,) sum of the CoM position over the ticks of this step, world, m.
        standing_height: (1,) hip height held while standing, m; moves slowly towards the commanded one.
        foothold: (2,) target of the swing sole, m.
        foot_desired: (n, 3, 3) desired position, velocity, acceleration (rows) of every sole; hip midpoint, heading.
        leg_reference: (n, n_leg) joint angles of the inverse kinematics, hip to ankle, rad.
        leg_rate: (n, n_leg) their rates, rad/s.
        inverse_fallbacks: (1,) ticks at which the inverse kinematics had no solution.
    """

    mode: IntVector
    walk_requested: IntVector
    stance: IntVector
    count: IntVector  # type: ignore[assignment]
    forced: IntVector
    time: Vector
    period: Vector
    place: Vector
    rate: Vector
    last_duration: Vector
    duration_ratio: Vector
    support_start: Matrix
    swing_start: Matrix
    swing_pitch_start: Vector
    swing_yaw_start: Vector
    heading: Vector
    heading_set: IntVector
    velocity_sum: Vector
    velocity_ticks: IntVector
    last_mean_velocity: Vector
    stride_mean: Vector
    settling: IntVector
    integral: Vector
    learnt: Vector
    speed: Vector
    station: Vector
    station_kept: IntVector
    last_position: Vector
    position_sum: Vector
    standing_height: Vector
    foothold: Vector
    foot_desired: Cube
    leg_reference: Matrix
    leg_rate: Matrix
    inverse_fallbacks: IntVector


def make_gait_inputs(parameters: GaitParameters) -> GaitInputs:
    """Kernel form of ``parameters``."""
    given = [np.atleast_1d(np.asarray(getattr(parameters, name), dtype=np.float64)) for name in GaitInputs._fields[:-1]]
    values = np.concatenate(given)
    ends = np.cumsum([len(part) for part in given])
    return GaitInputs(*np.split(values, ends[:-1]), values)  # type: ignore[call-arg]


def make_step_state(n_soles: int, n_leg: int) -> StepState:
    """State of a robot at rest on both feet; ``n_leg`` joints a leg."""
    shapes: dict[str, tuple[int, ...]] = {
        **dict.fromkeys(StepState._fields, (1,)),
        **dict.fromkeys(("velocity_sum", "last_mean_velocity", "stride_mean", "integral", "learnt"), (2,)),
        **dict.fromkeys(("speed", "station", "last_position", "position_sum", "foothold"), (2,)),
        **dict.fromkeys(("leg_reference", "leg_rate"), (n_soles, n_leg)),
        "support_start": (3, 3),
        "swing_start": (2, 3),
        "foot_desired": (n_soles, 3, 3),
    }
    whole = {name for name, hint in StepState.__annotations__.items() if "Int" in str(hint)}
    state = {name: np.zeros(shape, dtype=np.int64 if name in whole else np.float64) for name, shape in shapes.items()}
    state["duration_ratio"][:] = state["rate"][:] = 1.0
    return StepState(**state)  # type: ignore[arg-type]
