"""What a run achieved, in numbers: speeds per stage, attitude, separation, torques, QP, time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import create_model

from gaitsmith.documents import Frozen
from gaitsmith.robots.parameters import GAIT_INPUTS
from gaitsmith.simulation.fall import Fall
from gaitsmith.simulation.reactions import Reaction

if TYPE_CHECKING:

    class StageCommand(Frozen):
        """Gait inputs that hold during a stage; SI units, zero speed at rest."""

        def __getattr__(self, name: str) -> float: ...

else:
    StageCommand = create_model(
        "StageCommand",
        __base__=Frozen,
        __module__=__name__,
        __doc__="Gait inputs that hold during a stage; SI units, zero speed at rest.",
        **{key: (float, ...) for name, about in GAIT_INPUTS.items() for key in about.keys or (name,)},
    )


class Stage(Frozen):
    """Between two changes of the command.

    Attributes:
        t0, t1: beginning and end, s.
        rest: whether rest was commanded.
        command: what was commanded.
        scored: beginning and end of the window of the means, s; see :func:`gaitsmith.simulation.stages.scored_window`.
        vx_mean, vy_mean: CoM velocity along the heading, less the heading's sway, m/s.
        vx_error, vy_error: mean minus command.
        height_mean, height_error: hip midpoint above the stance sole, and that minus the command, m.
        yaw_rate_mean, yaw_rate_error: of the torso, and that minus the command, rad/s.
        heading_drift_deg: change of the heading over the whole stage, less the turn that was commanded meanwhile.
        roll_deg, pitch_deg: lowest and highest over the whole stage.
        settled_roll_deg, settled_pitch_deg: the same over the last 2 s.
    """

    t0: float
    t1: float
    rest: bool
    command: StageCommand
    scored: tuple[float, float]
    vx_mean: float
    vx_error: float
    vy_mean: float
    vy_error: float
    height_mean: float
    height_error: float
    yaw_rate_mean: float
    yaw_rate_error: float
    heading_drift_deg: float
    roll_deg: tuple[float, float]
    pitch_deg: tuple[float, float]
    settled_roll_deg: tuple[float, float]
    settled_pitch_deg: tuple[float, float]


class QpCounts(Frozen):
    """Whole-body QP: ticks that solved it, that fell back, and that found it infeasible."""

    solves: int
    fallbacks: int
    infeasible: int


class TickTimes(Frozen):
    """Wall time of the controller's tick, µs, and how many took longer than the control period of 1 ms."""

    median: float
    p99: float
    max: float
    overruns: int


class StepTimes(Frozen):
    """Durations of the steps taken, s."""

    mean: float
    min: float
    max: float


class Memory(Frozen):
    """Memory of the process that is in use, MB, when the run began and when it was summed up."""

    start: float
    end: float


class LogCounts(Frozen):
    """Rows of the log, rows that it lacks, and whether its file is complete."""

    rows: int
    dropped: int
    complete: bool


class FootPitch(Frozen):
    """Mean pitch of the soles as heels meet and toes leave the ground, degrees, as it was and as planned."""

    strike: float
    off: float
    planned_strike: float
    planned_off: float


class BallReport(Frozen):
    """A ball that was kicked: largest speed, m/s, as it was and as planned; distance that it went, m."""

    speed: float
    planned_speed: float
    travel: float


class Tracking(Frozen):
    """How well a planned gait was followed.

    Attributes:
        distance, planned_distance: travel of the CoM along x, m.
        turn_deg, planned_turn_deg: of the torso to the left.
        tilt_deg: largest deviation of the torso from the plan.
        zmp_rms_mm: distance of the real ZMP from the planned one in single support.
        foot_pitch_deg: None for a gait without heel and toe phases.
        ball: None without one.
        phase: of the plan at the end.
        ended: whether the plan had ended.
    """

    distance: float
    planned_distance: float
    turn_deg: float
    planned_turn_deg: float
    tilt_deg: dict[str, float]
    zmp_rms_mm: float
    foot_pitch_deg: FootPitch | None
    ball: BallReport | None
    phase: str
    ended: bool


class TourReport(Frozen):
    """Score of a tour.

    Attributes:
        position_error: distance from every waypoint that was gone for, when its time was over, m.
        yaw_error_deg: the same of the heading, without sign.
        energy: mechanical work of all joints since the walk began, whatever its sign, J.
    """

    position_error: tuple[float, ...]
    yaw_error_deg: tuple[float, ...]
    energy: float


class Summary(Frozen):
    """A run in numbers.

    Attributes:
        fell, fall: whether the robot fell, and the fall.
        interrupted: whether the run was cut short from outside.
        robot, preset, state, terrain, seed: what was run.
        duration: simulated, s.
        steps: taken.
        stages: in order of time, rests included.
        drift: largest horizontal excursion of the torso since the walk began, m.
        distance: horizontal distance between the torso's places at the walk's beginning and at the end, m.
        yaw_deg: lowest and highest, between -180 and 180.
        heading_deg: the same of the heading, which goes on where the yaw turns over.
        min_foot_separation: smallest lateral distance, left minus right, of the sole frames' origins in the heading
            frame, over all physics steps, m.
        leg_contacts: how many times one leg came to touch the other.
        torque_peak: largest magnitude per joint, N·m.
        torque_saturated: share of ticks at the limit, per joint.
        torque_step_max: largest change from one tick to the next per joint, N·m, while walking undisturbed: not within
            1.5 s after a push, a command, or the beginning of the walk.
        velocity_peak: largest speed per joint as the controller sees it, rad/s.
        velocity_over: share of ticks beyond the speed limit, per joint.
        control_state: of the controller at the end, by name.
        refused: ticks in which readings were replaced, by sensor.
        memory_mb: None if nobody was there to measure it.
        log: None if nothing was recorded.
        qp: counts of the whole-body QP.
        tick_us: wall time of the controller's tick.
        realtime_factor: simulated over wall time, logging included.
        pushes: when each push began, s; null if it never did.
        recovered: how long after its beginning each push was recovered from, s
            (:class:`gaitsmith.simulation.strides.Strides`); null if it was not; empty with a plan without a loop.
        step_time: of finished steps of the template, or of a plan in its loop; None without one.
        warnings: what the physics engine warned of.
        tracking: of a planned gait; None for the template's.
        steps_held: of a walk by a library: how many steps stayed as they were because a gait on the way could not be
            planned; None without one, and in a summary made from a log.
        tour: of a run of the teleoperation test; else None.
        faults: what failed, as the controller noticed it, and what it did; faults that it did not notice say so.
    """

    fell: bool
    fall: Fall | None
    interrupted: bool
    robot: str
    preset: str
    state: str
    terrain: str
    seed: int
    duration: float
    steps: int
    stages: tuple[Stage, ...]
    drift: float
    distance: float
    yaw_deg: tuple[float, float]
    heading_deg: tuple[float, float]
    min_foot_separation: float
    leg_contacts: int
    torque_peak: dict[str, float]
    torque_saturated: dict[str, float]
    torque_step_max: dict[str, float]
    velocity_peak: dict[str, float]
    velocity_over: dict[str, float]
    control_state: str
    refused: dict[str, int]
    memory_mb: Memory | None
    log: LogCounts | None
    qp: QpCounts
    tick_us: TickTimes
    realtime_factor: float
    pushes: tuple[float | None, ...]
    warnings: tuple[str, ...]
    recovered: tuple[float | None, ...] = ()
    step_time: StepTimes | None = None
    tracking: Tracking | None = None
    steps_held: int | None = None
    tour: TourReport | None = None
    faults: tuple[Reaction, ...] = ()
