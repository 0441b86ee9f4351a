"""Bipeds that nobody built, as MJCF: every trait that adoption has to see through can be switched."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np

AXES = {"roll": (1.0, 0.0, 0.0), "pitch": (0.0, 1.0, 0.0), "yaw": (0.0, 0.0, 1.0)}
TRAPEZOID = ((-0.05, 0.025), (0.12, 0.03), (0.12, -0.03), (-0.05, -0.025))


@dataclass
class MadeUp:
    """A biped of 30 kg with legs of 0.7 m.

    Attributes:
        hip, ankle: roles of the joints above and below the knee, in order.
        slant: rad, by which every axis of the hips is turned out of its plane.
        reversed_joints: roles whose axes point the other way; their ranges follow.
        turned: rad, of everything about the vertical inside the root body.
        waist: joints between the root, then the upper body, and the pelvis.
        sole: box, stilt (a box far below), trapezoid (four balls), line (one capsule), ball, wheel, disc, paired (a box
            that only a scene lets collide), or none.
        ankle_ball: whether the link between the ankle's joints collides as a ball.
        toes: whether a toe joint with a shape of its own follows.
        bend: rad, of the zero pose's knees; the feet tilt with it.
        floating: whether the file has a free joint.
        scale: of all lengths.
        extra_legs: pairs of legs behind these.
        sides: of the legs, +1 for left, in the file's order.
        coupled: two joints held together by an equality.
        strength: of the legs' motors, N·m.
        arm_strength: of the arms' motors, which then hold the arms forward, N·m.
        tail: whether a chain of three joints, none of them an ankle, hangs to the ground.
        names: of joints, instead of the made-up ones.
    """

    hip: tuple[str, ...] = ("yaw", "roll", "pitch")
    ankle: tuple[str, ...] = ("pitch", "roll")
    slant: float = 0.0
    reversed_joints: tuple[str, ...] = ()
    turned: float = 0.0
    waist: int = 0
    sole: str = "box"
    ankle_ball: bool = False
    toes: bool = False
    bend: float = 0.0
    floating: bool = True
    scale: float = 1.0
    extra_legs: int = 0
    sides: tuple[int, ...] = (1, -1)
    coupled: tuple[str, ...] = ()
    strength: float = 150.0
    arm_strength: float = 0.0
    tail: bool = False
    names: dict[str, str] = field(default_factory=dict)

    def text(self) -> str:
        """The model."""
        legs = "".join(self._leg(side, -0.4 * k) for k in range(1 + self.extra_legs) for side in self.sides)
        arms = "".join(self._arm(side) for side in (1, -1))
        upper = f'<inertial pos="0 0 .2" mass="14" diaginertia=".4 .3 .2"/>{self._geom(".1 .12 .2", "0 0 .25")}{arms}'
        pelvis = f'<inertial pos="0 0 0" mass="4" diaginertia=".03 .03 .03"/>{legs}{self._tail()}'
        free = '<freejoint name="base"/>' if self.floating else ""
        turn = f'<frame euler="0 0 {self.turned}">'
        if self.waist:
            joints = "".join(
                f'<joint name="w{k}" axis="{axis}" range="-1 1"/>'
                for k, axis in enumerate(("0 0 1", "0 1 0", "1 0 0")[: self.waist])
            )
            body = f'<body name="chest" pos="0 0 1">{free}{turn}{upper}<body name="pelvis" pos="0 0 -.1">{joints}'
            body += f"{pelvis}</body></frame></body>"
        else:
            body = (
                f'<body name="pelvis" pos="0 0 1">{free}{turn}{pelvis}<body name="chest">{upper}</body></frame></body>'
            )
        return (
            '<mujoco model="made_up"><compiler angle="radian" autolimits="true"/>'
            f'<default><joint armature=".01"/></default><worldbody>{body}</worldbody>'
            f"{self._equality()}</mujoco>"
        )

    def model(self) -> mujoco.MjModel:
        """Compiled, with a free joint."""
        made = MadeUp(**{**vars(self), "floating": True})
        return mujoco.MjModel.from_xml_string(made.text())

    def _equality(self) -> str:
        if not self.coupled:
            return ""
        first, second = self.coupled
        return f'<equality><joint joint1="{first}" joint2="{second}"/></equality>'

    def _geom(self, size: str, place: str) -> str:
        return f'<geom type="box" size="{size}" pos="{place}" density="0"/>'

    def _joint(self, name: str, role: str, side: int, low: float, high: float, slanted: bool) -> str:
        axis = np.array(AXES[role])
        if slanted and self.slant:
            other = np.array(AXES[{"roll": "yaw", "pitch": "roll", "yaw": "pitch"}[role]])
            axis = np.cos(self.slant) * axis + np.sin(self.slant) * side * other
        if role in self.reversed_joints:
            axis, low, high = -axis, -high, -low
        words = " ".join(f"{v:.9f}" for v in axis)
        name = self.names.get(name, name)
        force = f'actuatorfrcrange="{-self.strength} {self.strength}"'
        return f'<joint name="{name}" axis="{words}" range="{low} {high}" {force}/>'

    def _leg(self, side: int, behind: float) -> str:
        s, tag = self.scale, f"{'l' if side > 0 else 'r'}{'' if behind == 0.0 else round(-10 * behind)}"
        inertia = '<inertial pos="0 0 {z}" mass="{m}" diaginertia=".01 .01 .004"/>'
        parts: list[str] = []
        for k, role in enumerate(self.hip):
            place = f"{behind} {side * 0.1 * s} {-0.05 * s}" if k == 0 else "0 0 0"
            limits = (-2.0, 1.0) if role == "pitch" else (-0.6, 0.6)
            last = k == len(self.hip) - 1
            parts += [f'<body name="{tag}_hip{k}" pos="{place}">', self._joint(f"{tag}h{k}", role, side, *limits, True)]
            parts += [inertia.format(z=-0.1 if last else 0, m=2.0 if last else 0.5)]
        thigh, shank = 0.35 * s, 0.35 * s
        parts += [f'<geom type="capsule" size=".03" fromto="0 0 -.05 0 0 {-0.8 * thigh}" density="0"/>']
        parts += [f'<body name="{tag}_shank" pos="0 0 {-thigh}" euler="0 {self.bend} 0">']
        parts += [self._joint(f"{tag}k", "pitch", side, 0.0, 2.3, False), inertia.format(z=-0.15, m=1.5)]
        parts += [f'<geom type="capsule" size=".025" fromto="0 0 0 0 0 {-0.8 * shank}" density="0"/>']
        for k, role in enumerate(self.ankle):
            place = f"0 0 {-shank}" if k == 0 else "0 0 0"
            limits = (-1.0, 0.8) if role == "pitch" else (-0.5, 0.5)
            parts += [
                f'<body name="{tag}_ankle{k}" pos="{place}">',
                self._joint(f"{tag}a{k}", role, side, *limits, False),
            ]
            parts += [inertia.format(z=0, m=0.3)]
            parts += ['<geom type="sphere" size=".02" density="0"/>'] if self.ankle_ball and k == 0 else []
        parts += [self._sole(tag), self._toe(tag, side), "</body>" * (len(self.hip) + 1 + len(self.ankle))]
        return "".join(parts)

    def _sole(self, tag: str) -> str:
        if self.sole == "paired":
            bits = 'contype="0" conaffinity="0" density="0"'
            return f'<geom name="{tag}_sole" type="box" size=".09 .04 .015" pos=".03 0 -.045" {bits}/>'
        if self.sole == "stilt":
            return '<geom type="box" size=".09 .04 .015" pos=".03 0 -.35" density="0"/>'
        if self.sole == "wheel":
            return '<geom type="cylinder" size=".08 .02" euler="1.5707963 0 0" density="0"/>'
        if self.sole == "disc":
            return '<geom type="cylinder" size=".08 .01" pos=".02 0 -.05" density="0"/>'
        if self.sole == "box":
            return f'<geom type="box" size=".09 .04 .015" pos=".03 0 {-0.045 * self.scale}" density="0"/>'
        if self.sole == "line":
            return '<geom type="capsule" size=".02" fromto="-.06 0 -.04 .12 0 -.04" density="0"/>'
        if self.sole == "ball":
            return '<geom type="sphere" size=".03" pos="0 0 -.03" density="0"/>'
        if self.sole == "trapezoid":
            return "".join(f'<geom type="sphere" size=".005" pos="{x} {y} -.05" density="0"/>' for x, y in TRAPEZOID)
        return ""

    def _toe(self, tag: str, side: int) -> str:
        if not self.toes:
            return ""
        body = f'<body name="{tag}_toe" pos=".12 0 -.03">{self._joint(f"{tag}t", "pitch", side, -0.5, 0.5, False)}'
        return (
            body
            + '<inertial pos="0 0 0" mass=".1" diaginertia=".001 .001 .001"/>'
            + ('<geom type="box" size=".03 .04 .015" pos=".03 0 -.015" density="0"/></body>')
        )

    def _tail(self) -> str:
        if not self.tail:
            return ""
        links = "".join(
            f'<body name="tail{k}" pos="{0 if k else -0.3} 0 {-0.25 if k else 0}"><joint name="t{k}" axis="{axis}"/>'
            '<inertial pos="0 0 -.1" mass=".1" diaginertia=".001 .001 .001"/>'
            f'<geom type="capsule" size=".01" fromto="0 0 0 0 0 {-0.25 if k < 2 else -0.3}" density="0"/>'
            for k, axis in enumerate(("1 0 0", "0 1 0", "0 1 0"))
        )
        return links + "</body>" * 3

    def _arm(self, side: int) -> str:
        tag, force = "L" if side > 0 else "R", self.arm_strength
        plain = 'range="-1.5 1.5"'
        held = f'range="-2 -1" actuatorfrcrange="{-force} {force}"' if force else plain
        links = "".join(
            f'<body name="{tag}_arm{k}" pos="{place}"><joint name="{tag}s{k}" axis="{axis}" '
            f"{held if k == 0 else plain}/>"
            '<inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .002"/>'
            '<geom type="capsule" size=".03" fromto="0 0 0 0 0 -.2" density="0"/>'
            for k, (place, axis) in enumerate(
                ((f"0 {side * 0.2} .4", "0 1 0"), ("0 0 -.02", "1 0 0"), ("0 0 -.25", "0 1 0"), ("0 0 -.02", "0 0 1"))
            )
        )
        return links + "</body>" * 4
