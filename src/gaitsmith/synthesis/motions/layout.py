"""Which number stands where in the inputs and outputs of one point of a gait.

Everything is in the frame of the support sole (x forward, z up, the sole standing flat). For a left support foot the
frame is mirrored (y to the right), so that the swing foot always lies at positive y.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Layout:
    """Index ranges for a robot of ``joints`` joints.

    Inputs of a point: joint angles, velocities, accelerations, then the wrench u on the other foot (force N, moment
    N·m about the pivot). Outputs: see the properties.
    """

    joints: int

    @property
    def inputs(self) -> int:
        """Number of inputs."""
        return 3 * self.joints + 6

    @property
    def outputs(self) -> int:
        """Number of outputs."""
        return self.joints + 39

    @property
    def position(self) -> int:
        """First joint angle among the inputs, rad."""
        return 0

    @property
    def velocity(self) -> int:
        """First joint velocity among the inputs, rad/s."""
        return self.joints

    @property
    def acceleration(self) -> int:
        """First joint acceleration among the inputs, rad/s²."""
        return 2 * self.joints

    @property
    def wrench(self) -> int:
        """First number of u among the inputs."""
        return 3 * self.joints

    @property
    def torque(self) -> int:
        """First joint torque, N·m."""
        return 0

    @property
    def force(self) -> int:
        """Force on the support sole (3), N."""
        return self.joints

    @property
    def moment(self) -> int:
        """Moment on the support sole about its origin (3), N·m."""
        return self.joints + 3

    @property
    def pivot(self) -> int:
        """Position of the other foot's pivot (3), m."""
        return self.joints + 6

    @property
    def foot_yaw(self) -> int:
        """Entry (1, 0) of the other sole's rotation."""
        return self.joints + 9

    @property
    def foot_pitch(self) -> int:
        """Minus entry (2, 0) of the other sole's rotation: the sine of its pitch, positive with the toe down."""
        return self.joints + 10

    @property
    def foot_roll(self) -> int:
        """Entry (2, 1) of the other sole's rotation."""
        return self.joints + 11

    @property
    def pivot_velocity(self) -> int:
        """Velocity of the pivot (3), m/s."""
        return self.joints + 12

    @property
    def foot_omega(self) -> int:
        """Angular velocity of the other foot (3), rad/s."""
        return self.joints + 15

    @property
    def pivot_acceleration(self) -> int:
        """Acceleration of the pivot (3), m/s²."""
        return self.joints + 18

    @property
    def foot_alpha(self) -> int:
        """Angular acceleration of the other foot (3), rad/s²."""
        return self.joints + 21

    @property
    def hip_height(self) -> int:
        """Height of the hips' midpoint, m."""
        return self.joints + 24

    @property
    def torso_yaw(self) -> int:
        """Entry (1, 0) of the torso's rotation."""
        return self.joints + 25

    @property
    def torso_pitch(self) -> int:
        """Minus entry (2, 0) of the torso's rotation: positive when it leans forward."""
        return self.joints + 26

    @property
    def torso_roll(self) -> int:
        """Entry (2, 1) of the torso's rotation."""
        return self.joints + 27

    @property
    def ankle(self) -> int:
        """Position of the other ankle (3), m."""
        return self.joints + 28

    @property
    def ankle_velocity(self) -> int:
        """Velocity of the other ankle (3), m/s."""
        return self.joints + 31

    @property
    def foot_forward(self) -> int:
        """Entry (0, 0) of the other sole's rotation."""
        return self.joints + 34

    @property
    def twist(self) -> int:
        """Vertical moment about the centre of pressure times the normal force, over the weight, N·m.

        Of the support sole, then of the other.
        """
        return self.joints + 35

    @property
    def load(self) -> int:
        """Square of the normal force over the weight, N, on the support sole, then on the other."""
        return self.joints + 37
