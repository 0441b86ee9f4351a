"""Control parameters: frozen, validated, in SI units. One :class:`ControlParameters` is one preset.

The kernels read the same numbers as plain named tuples; this module only says what they are, what they mean, and which
values make sense. A card gives some of them, as :data:`CardPreset`; the rest follow from the robot's size, mass and
gravity (:mod:`gaitsmith.control.defaults`).
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from gaitsmith.robots.parameters import Fraction, NonNegative, Parameters, Positive, partial

Pair = tuple[NonNegative, NonNegative]


class FootholdParameters(Parameters):
    """Foothold adjustment (Han 2023, eq. 15) and what removes its bias.

    Attributes:
        velocity_gain: k_v forward and lateral, s; multiplies the velocity error.
        acceleration_gain: k_a, s²; multiplies the CoM acceleration.
        deadbeat: share of a linear pendulum's own gain in k_v: 1 uses ``coth(ωT) / ω``, which stops the pendulum
            within one step whatever the period, 0 the fixed k_v of the paper.
        prediction: share of a linear pendulum's forecast in the velocity: 0 takes the present velocity, as in the
            paper, 1 the one expected at touchdown.
        mean_speed: 1 compares the velocity at touchdown with what a pendulum has there when its mean over the step
            is the command, takes the step's length from how long steps really last, and measures the foothold from
            the CoM; 0 compares with the command itself, takes ``T v_d`` and measures from the hip midpoint, as in
            the paper.
        sway: share of a pendulum's sway between soles ``2 W`` apart in the lateral velocity that is compared with.
        reach: largest forward distance from the hip midpoint to the foothold, m.
        spread: largest lateral distance from the hip midpoint to the foothold, m.
        separation: smallest lateral distance between the stance sole and the foothold, m.
    """

    velocity_gain: Pair
    acceleration_gain: NonNegative
    deadbeat: Fraction
    prediction: Fraction
    mean_speed: Fraction
    sway: Fraction
    reach: Positive
    spread: Positive
    separation: Positive


class SpeedParameters(Parameters):
    """The speed that a step is taken for: the command, and what is added to it.

    Attributes:
        integral_gain: share of the mean speed's error learnt a step, forward and lateral.
        integral_limit: bound on what is learnt, m/s.
        largest_error: error beyond which nothing more is learnt from a step, m/s; after a stride that differs by more
            than that from the one before nothing is learnt for a while: a push is no bias.
        station_gain: speed per metre of drift while the commanded speed is zero, forward and lateral, 1/s.
        station_limit: bound on that speed, m/s.
        settled_speed: mean speed below which a robot commanded to zero has arrived and keeps its station, m/s.
    """

    integral_gain: Pair
    integral_limit: NonNegative
    largest_error: Positive
    station_gain: Pair
    station_limit: NonNegative
    settled_speed: Positive


class StepTimeParameters(Parameters):
    """Step time adapted within the step when the foothold is out of reach.

    Attributes:
        shortest: share of the period below which no step is shortened; 1 keeps every step's time.
        foot_speed: speed of the swing foot that is counted on, m/s.
    """

    shortest: Annotated[float, Field(gt=0.0, le=1.0)]
    foot_speed: Positive


class PrintedParameters(Parameters):
    """Which references are the paper's as printed (Han 2023); false takes what stands in for them.

    Attributes:
        support_height: eq. 7: a new height of the hips is reached at αT; else at T.
        support_place: eqs. 8 and 9 from the desired state at the switch (section 2.2, first rule): the stance sole's y
            goes to ±W, its x through 0 to half a step behind; else both are where the sole is.
        swing_via: eqs. 10 and 11: at αT the swing sole passes x = 0 and y = ±W; else the middle of its way.
        swing_frame: eq. 19: the acceleration that Γ2 compares is the world's; else relative to the hips, as p^d is.
        swing_feedback: eq. 20 alone; else the curve's own acceleration is added.
        joint_reference: section 4.1: q^d = q + Δq, from the measured joints; else from the last q^d.
    """

    support_height: bool
    support_place: bool
    swing_via: bool
    swing_frame: bool
    swing_feedback: bool
    joint_reference: bool


class CopParameters(Parameters):
    """Centre of pressure of the stance sole: k (ξ - ξ_ref) from the sole's origin, as a soft target.

    Attributes:
        gain: k forward and lateral.
        weight: cost of the moment by which it is missed, (N·m)⁻².
    """

    gain: Pair
    weight: NonNegative


class AttitudeParameters(Parameters):
    """Virtual spring and damper on the torso's roll, pitch (Han 2023, eq. 21) and yaw: k¹ in 1/s², k² in 1/s."""

    roll_stiffness: NonNegative
    roll_damping: NonNegative
    pitch_stiffness: NonNegative
    pitch_damping: NonNegative
    yaw_stiffness: NonNegative
    yaw_damping: NonNegative


class TrackingParameters(Parameters):
    """Acceleration references of joints and swing foot (Han 2023, eqs. 20 and 22): 1/s² and 1/s."""

    joint_stiffness: NonNegative
    joint_damping: NonNegative
    foot_stiffness: NonNegative
    foot_damping: NonNegative


class StandingParameters(Parameters):
    """Balance on both feet, and when a walk begins and ends.

    Attributes:
        com_stiffness: 1/s².
        com_damping: 1/s.
        weight: cost of the CoM acceleration error.
        weight_shift: whether the weight is shifted over the first stance foot before the other is lifted.
        longest_shift: s after which the first step is taken anyway.
        entry_speed: largest CoM speed at which a walk may end in standing, m/s.
        straddle: forward distance of the soles up to which it may, m.
        height_rate: how fast the hips follow a new height while standing, m/s.
    """

    com_stiffness: NonNegative
    com_damping: NonNegative
    weight: Positive
    weight_shift: bool
    longest_shift: Positive
    entry_speed: Positive
    straddle: Positive
    height_rate: Positive


class TaskWeights(Parameters):
    """Weights of the whole-body QP's cost (Han 2023, eqs. 18-25 and its corrections)."""

    stance_linear: Positive
    stance_angular: NonNegative
    swing_foot: NonNegative
    attitude: NonNegative
    yaw: NonNegative
    knee: NonNegative
    swing_joint: NonNegative
    swing_ankle: NonNegative
    other_joint: NonNegative
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


class JointParameters(Parameters):
    """Bounds on the joints besides their torque limits.

    Attributes:
        torque_rate: fastest change of a torque, N·m/s: what blends the torques when the legs switch.
        stop_rate: rate of the critically damped approach that a joint may make to its stop, 1/s.
    """

    torque_rate: Positive
    stop_rate: Positive


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
    """Joint PD of eq. 27, hip to ankle, for a swing and for a stance leg: N·m/rad and N·m·s/rad; empty for none."""

    swing_stiffness: tuple[NonNegative, ...]
    swing_damping: tuple[NonNegative, ...]
    stance_stiffness: tuple[NonNegative, ...]
    stance_damping: tuple[NonNegative, ...]


class OtherJointGains(Parameters):
    """Joints outside the legs hold their posture: 1/s² and 1/s for the QP's acceleration reference."""

    stiffness: NonNegative
    damping: NonNegative


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

    accelerometer: Positive
    accelerometer_drift: Positive
    leg_odometry: Positive
    foot_height: Positive
    joint_acceleration: Positive
    encoder: Positive


class ControlParameters(Parameters):
    """One preset: every number the controller uses besides the gait template's own inputs."""

    foothold: FootholdParameters
    speed: SpeedParameters
    step_time: StepTimeParameters
    printed: PrintedParameters
    cop: CopParameters
    attitude: AttitudeParameters
    tracking: TrackingParameters
    standing: StandingParameters
    weights: TaskWeights
    contact: ContactParameters
    joints: JointParameters
    touchdown: TouchdownParameters
    inverse_kinematics: InverseKinematicsParameters
    joint_gains: JointGains
    joint_gains_estimated: JointGains
    other_joints: OtherJointGains
    estimator: EstimatorParameters


CardPreset: Any = partial(ControlParameters)
"""What a card says of a preset: any entries of :class:`ControlParameters`."""
