"""Gait and control parameters of a robot card: frozen, validated, in SI units.

One :class:`ControlParameters` is one preset. The kernels read the same numbers as plain named tuples; this module
only says what they are, what they mean, and which values make sense.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, create_model

from gaitsmith.documents import About
from gaitsmith.errors import BadInput

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]


class Parameters(BaseModel):
    """Base of all parameter groups: frozen, no unknown keys, no NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True)
class GaitInput(About):
    """What one input of the gait template is; everything that names it is derived from this.

    Attributes:
        parts: names of its numbers in limits and telemetry, if it has several; else its own name is taken.
        keys: their names in a summary.
        stops: whether it is zero at rest.
        fixed: what it means that a robot's limits leave a single value.
    """

    parts: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()
    stops: bool = False
    fixed: str = ""


class GaitParameters(Parameters):
    """The gait template's inputs (Han 2023, section 2, and a turning rate); all may change while walking.

    This is their only declaration: limits, commands, flags, summaries and telemetry columns follow from it.
    """

    speed: Annotated[
        tuple[Finite, Finite],
        GaitInput(
            "Commanded CoM velocity in the heading frame, forward and to the left",
            "m/s",
            "VX [VY]",
            parts=("speed_x", "speed_y"),
            keys=("vx", "vy"),
            stops=True,
        ),
    ] = (0.0, 0.0)
    period: Annotated[Positive, GaitInput("Duration T of one step", "s", "S")]
    alpha: Annotated[Fraction, GaitInput("Lifting stage's share of the period", "", "A")] = 0.5
    height: Annotated[Positive, GaitInput("Height H of the hip midpoint above the stance sole", "m", "M")]
    lift: Annotated[Positive, GaitInput("Height h of the swing sole at the end of the lifting stage", "m", "M")]
    width: Annotated[Positive, GaitInput("Half the lateral distance W between the soles", "m", "M")]
    yaw_rate: Annotated[
        Finite,
        GaitInput(
            "Rate at which the heading turns, to the left", "rad/s", "W", stops=True, fixed="the legs cannot turn"
        ),
    ] = 0.0


GAIT_INPUTS: dict[str, GaitInput] = {
    name: next(entry for entry in field.metadata if isinstance(entry, GaitInput))
    for name, field in GaitParameters.model_fields.items()
}


def gait_numbers(gait: Mapping[str, Any], keys: bool = False) -> Iterator[tuple[str, str, Any]]:
    """Every number of some gait inputs: its name in limits (or in a summary), its place in the input, its value."""
    for name, value in gait.items():
        about = GAIT_INPUTS[name]
        for k, part in enumerate(about.keys if keys and about.keys else about.parts or (name,)):
            yield (part, f"{name}[{k}]", value[k]) if about.parts else (part, name, value)


def _range(name: str) -> Any:
    """Annotation and default of the limits of one number of the gait; an input that may be absent is fixed then."""
    about = GAIT_INPUTS[name]
    default = (0.0, 0.0) if about.fixed else ...
    return tuple[Finite, Finite], default


if TYPE_CHECKING:

    class GaitLimits(Parameters):
        """Valid closed ranges of the numbers of the gait, (lowest, highest)."""

        def __getattr__(self, name: str) -> tuple[float, float]: ...

else:
    GaitLimits = create_model(
        "GaitLimits",
        __base__=Parameters,
        __module__=__name__,
        __doc__="Valid closed ranges of the numbers of the gait, (lowest, highest).",
        **{part: _range(name) for name, about in GAIT_INPUTS.items() for part in about.parts or (name,)},
    )


def at_rest(gait: Mapping[str, Any]) -> dict[str, Any]:
    """The inputs with those at zero that stop at rest."""
    return {
        name: GaitParameters.model_fields[name].default if GAIT_INPUTS[name].stops else value
        for name, value in gait.items()
    }


def check_gait(gait: Mapping[str, Any], limits: GaitLimits, prefix: str = "") -> None:
    """Check gait inputs against a robot's limits.

    Args:
        gait: any of the inputs, by name.
        limits: of the robot.
        prefix: put before the name of what is wrong.

    Raises:
        BadInput: an unknown input, something else than numbers, or a number outside the limits.
    """
    for name, value in gait.items():
        if name not in GAIT_INPUTS:
            raise BadInput(f"{prefix}{name}", value, f"one of {', '.join(GAIT_INPUTS)}")
        about = GAIT_INPUTS[name]
        listed = isinstance(value, (tuple, list)) or getattr(value, "ndim", 0) > 0
        if listed != bool(about.parts) or (listed and len(value) != len(about.parts)):
            count = f"{len(about.parts)} numbers" if about.parts else "one number"
            raise BadInput(f"{prefix}{name}", value, f"{count}: {about.meaning}, {about.unit}")
    for part, place, value in gait_numbers(gait):
        low, high = getattr(limits, part)
        about = GAIT_INPUTS[place.partition("[")[0]]
        if isinstance(value, bool) or not isinstance(value, Real) or not low <= value <= high:
            alone = low == high
            valid = f"{low:g} only" if alone else f"{low:g} to {high:g} {about.unit}".strip()
            raise BadInput(f"{prefix}{place}", value, valid, about.fixed if alone else "")


class FootholdParameters(Parameters):
    """Foothold adjustment (Han 2023, eq. 15) and what removes its bias.

    Attributes:
        velocity_gain: k_v forward and lateral, s; multiplies the velocity error.
        deadbeat: share of a linear pendulum's own gain in k_v: 1 uses ``coth(ωT) / ω``, which stops the pendulum
            within one step whatever the period, 0 the fixed k_v of the paper.
        acceleration_gain: k_a, s²; multiplies the CoM acceleration.
        prediction: share of a linear pendulum's forecast in the velocity: 0 takes the present velocity, as in the
            paper, 1 the one expected at touchdown.
        mean_speed: 1 compares the velocity at touchdown with what a pendulum has there when its mean over the step
            is the command, takes the step's length from how long steps really last, and measures the foothold from
            the CoM; 0 compares with the command itself, takes ``T v_d`` and measures from the hip midpoint, as in
            the paper.
        integral_gain: per-step integral of the mean velocity error, forward and lateral, s.
        integral_limit: bound on the integral's contribution, m.
        station_gain: offset of the foothold per metre of drift while the commanded speed is zero.
        station_limit: bound on the station-keeping offset, m.
        reach: largest forward distance from the hip midpoint to the foothold, m.
        spread: largest lateral distance from the hip midpoint to the foothold, m.
        separation: smallest lateral distance between the stance sole and the foothold, m.
    """

    velocity_gain: tuple[NonNegative, NonNegative]
    acceleration_gain: NonNegative = 0.0
    deadbeat: Fraction = 0.0
    prediction: Fraction = 0.0
    mean_speed: Fraction = 0.0
    integral_gain: tuple[NonNegative, NonNegative] = (0.0, 0.0)
    integral_limit: NonNegative = 0.15
    station_gain: tuple[NonNegative, NonNegative] = (0.0, 0.0)
    station_limit: NonNegative = 0.05
    reach: Positive
    spread: Positive
    separation: Positive


class AnkleParameters(Parameters):
    """Soft target for the stance ankle torque, proportional to the speed error.

    Attributes:
        speed_gain: N·m per m/s of speed error.
        torque_limit: bound on the target, N·m.
    """

    speed_gain: NonNegative = 0.0
    torque_limit: NonNegative = 0.0


class AttitudeParameters(Parameters):
    """Virtual spring and damper on torso roll and pitch (Han 2023, eq. 21): k¹ in 1/s², k² in 1/s."""

    roll_stiffness: NonNegative
    roll_damping: NonNegative
    pitch_stiffness: NonNegative
    pitch_damping: NonNegative


class TrackingParameters(Parameters):
    """Acceleration references of joints and swing foot (Han 2023, eqs. 20 and 22): 1/s² and 1/s."""

    joint_stiffness: NonNegative
    joint_damping: NonNegative
    foot_stiffness: NonNegative
    foot_damping: NonNegative


class StandingParameters(Parameters):
    """Balance on both feet: CoM over the middle of the soles, hip height held.

    Attributes:
        com_stiffness: 1/s².
        com_damping: 1/s.
        weight: cost of the CoM acceleration error.
        entry_speed: largest CoM speed at which a walk may end in standing, m/s.
    """

    com_stiffness: NonNegative
    com_damping: NonNegative
    weight: Positive
    entry_speed: Positive


class TaskWeights(Parameters):
    """Weights of the whole-body QP's cost (Han 2023, eqs. 18-25 and its corrections)."""

    stance_linear: Positive
    stance_angular: NonNegative
    swing_foot: NonNegative
    attitude: NonNegative
    knee: NonNegative
    swing_joint: NonNegative
    swing_ankle: NonNegative
    other_joint: NonNegative = 1.0
    ankle_torque: NonNegative
    torque_change: NonNegative
    regularisation: Positive


class ContactParameters(Parameters):
    """Bounds on the sole wrench in the whole-body QP (Han 2023, eq. 26 and its corrections).

    Attributes:
        friction: Coulomb coefficient of the friction pyramid.
        normal_force: smallest and largest normal force on a stance sole, N.
        zmp_margin: distance of the ZMP from the sole's edge, m.
        yaw_friction: largest |τz| per newton of normal force, m.
    """

    friction: Positive
    normal_force: tuple[NonNegative, Positive]
    zmp_margin: NonNegative
    yaw_friction: NonNegative


class TouchdownParameters(Parameters):
    """When a step ends.

    Attributes:
        force: sole force that counts as contact, N.
        earliest: share of the period before which contact is ignored.
        latest: share of the period at which the step is ended anyway.
        descent_speed: speed at which the swing sole goes on downwards after the period, m/s.
    """

    force: Positive
    earliest: Fraction
    latest: Annotated[float, Field(ge=1.0, le=3.0)]
    descent_speed: NonNegative


class InverseKinematicsParameters(Parameters):
    """Inverse kinematics QP (Han 2023, eqs. 28-32).

    Attributes:
        gain: k_IK, 1/s.
        step_weight: Q2, on the increment.
        change_weight: Q3, on the change of the increment.
        pitch_weight: Q4, on the sole's orientation error, relative to Q1 = 1.
    """

    gain: Positive
    step_weight: Positive
    change_weight: NonNegative
    pitch_weight: NonNegative


class JointGains(Parameters):
    """Joint PD of eq. 27, hip to ankle, for a swing and for a stance leg: N·m/rad and N·m·s/rad."""

    swing_stiffness: tuple[NonNegative, ...]
    swing_damping: tuple[NonNegative, ...]
    stance_stiffness: tuple[NonNegative, ...]
    stance_damping: tuple[NonNegative, ...]


class OtherJointGains(Parameters):
    """Joints outside the legs hold the model's zero position: 1/s² and 1/s for the QP's acceleration reference."""

    stiffness: NonNegative = 100.0
    damping: NonNegative = 20.0


class EstimatorParameters(Parameters):
    """Standard deviations of the Kalman filters (Han 2023, section 4.3).

    Attributes:
        accelerometer: noise of the specific force, m/s².
        accelerometer_drift: random walk of its bias, m/s² per √s.
        leg_odometry: noise of the stance foot's velocity, m/s.
        foot_height: noise of the stance foot's height, m.
        joint_acceleration: process noise of the joint-velocity filter, rad/s².
        encoder: noise of a joint angle, rad.
    """

    accelerometer: Positive = 0.3
    accelerometer_drift: Positive = 0.02
    leg_odometry: Positive = 0.1
    foot_height: Positive = 0.005
    joint_acceleration: Positive = 200.0
    encoder: Positive = 3e-4


class ControlParameters(Parameters):
    """One preset: every number the controller uses besides the gait template's own inputs."""

    foothold: FootholdParameters
    ankle: AnkleParameters = AnkleParameters()
    attitude: AttitudeParameters
    tracking: TrackingParameters
    standing: StandingParameters
    weights: TaskWeights
    contact: ContactParameters
    touchdown: TouchdownParameters
    inverse_kinematics: InverseKinematicsParameters
    joint_gains: JointGains
    joint_gains_estimated: JointGains
    other_joints: OtherJointGains = OtherJointGains()
    estimator: EstimatorParameters = EstimatorParameters()
