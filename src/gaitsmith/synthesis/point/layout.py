"""Which number stands where in the inputs and outputs of one point of a gait.

Everything is in the frame of the support sole (x forward, z up, the sole standing flat). For a left support foot the
frame is mirrored (y to the right), so that the swing foot always lies at positive y.
"""

from __future__ import annotations

from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.motion import Side

KINDS = ("value", "jacobian", "hessian")
"""The functions of a point."""


def sides_of(biped: Biped) -> tuple[Side, ...]:
    """The support feet that need functions of their own: one stands for both in a robot that is its mirror image."""
    return ("right",) if biped.symmetric else ("right", "left")


class PointLayout:
    """Indices for a robot of n joints; of a vector its first entry.

    Attributes:
        joints: n.
        leans: 2 for line soles, else 0: the support sole's roll about its line, and the other's, rad.
        poses: 6 where the support sole may fly: its x, y, z (m, from its foothold), yaw, pitch and roll; 1 where it may
            turn about its toe's edge: its pitch; else 0.
        coordinates: c = n + leans + poses.
        inputs, outputs: how many numbers there are.
        position, velocity, acceleration: inputs: joint angles, then leans, then the pose (c), SI.
        wrench: inputs: u on the other foot: force (3), N, then moment about the pivot (3), N·m.
        torque: of the joints (n), N·m.
        force: on the support sole (3), N; its moment follows.
        moment: on the support sole about its origin (3), N·m.
        pivot, pivot_velocity, pivot_acceleration: of the other foot's pivot (3), m, m/s, m/s².
        foot_forward, foot_yaw, foot_pitch, foot_roll: entries (0, 0), (1, 0), minus (2, 0), (2, 1) of the other sole's
            rotation; the sine of its pitch is positive with the toe down.
        foot_omega, foot_alpha: angular velocity and acceleration of the other foot (3), rad/s, rad/s².
        hip_height: of the hips' midpoint, m.
        torso_yaw, torso_pitch, torso_roll: entries (1, 0), minus (2, 0), (2, 1) of the torso's rotation; the pitch is
            positive when it leans forward.
        ankle, ankle_velocity: of the other ankle (3), m, m/s.
        lean_gap: of line soles: sine of the other sole's roll less its lean.
        own: of a support sole that may move: place (3), then yaw, pitch and roll as of the other sole.
        com, momentum, body: where places are wanted: centre of mass (3), m, its velocity (3), m/s, and the torso's
            frame (3), m.
        edge: of a support sole that may turn about its toe's edge: moment about that, N·m.
        spin: of a robot that may fly: angular momentum about the foothold over the mass (3), m²/s.
        twist: vertical moment about the centre of pressure times the normal force, over the weight, N·m; of the support
            sole, then of the other.
        load: square of the normal force over the weight, N; on the support sole, then on the other.
    """

    def __init__(self, joints: int, leans: int = 0, poses: int = 0, places: bool = False) -> None:
        self.joints = n = joints
        self.leans, self.poses, self.coordinates = leans, poses, n + leans + poses
        self.pose = n + leans  # first of the pose among the coordinates
        self.position, self.velocity, self.acceleration, self.wrench = (k * self.coordinates for k in range(4))
        self.inputs = self.wrench + 6
        self.torque, self.force, self.moment = 0, n, n + 3
        self.pivot, self.foot_yaw, self.foot_pitch, self.foot_roll = n + 6, n + 9, n + 10, n + 11
        self.pivot_velocity, self.foot_omega = n + 12, n + 15
        self.pivot_acceleration, self.foot_alpha = n + 18, n + 21
        self.hip_height, self.torso_yaw, self.torso_pitch, self.torso_roll = n + 24, n + 25, n + 26, n + 27
        self.ankle, self.ankle_velocity, self.foot_forward = n + 28, n + 31, n + 34
        self.lean_gap = n + 35
        self.own = n + 35 + leans // 2
        self.places = places
        self.com, self.momentum, self.body, self.spin = (self.own + 6 * (poses > 0) + 3 * k * places for k in range(4))
        self.edge = self.spin
        self.twist = self.spin + (1 if poses == 1 else poses // 2)
        self.load, self.outputs = self.twist + 2, self.twist + 4


def layout_of(biped: Biped) -> PointLayout:
    """The layout of a robot's points."""
    return PointLayout(biped.joints, biped.leans, 6 * biped.flies or int(biped.tips), biped.flies or biped.placed)
