"""The paper's claims about its two cyclic gaits (section 5), each with our figure and a verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.support import contact_points, hull, inside
from gaitsmith.synthesis.gaits.unrolled import Samples, UnrolledGait
from gaitsmith.synthesis.motions.biped import Biped, biped_from
from gaitsmith.synthesis.proof.verify import verify

Array = npt.NDArray[np.float64]
_SAMPLES = 1200
_UPRIGHT = 0.9  # cosine


@dataclass(frozen=True)
class Claim:
    """One claim: the paper's words in short, what we find, and whether it holds here."""

    claim: str
    found: str
    holds: bool

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return dict(vars(self))


def _inside(samples: Samples, biped: Biped) -> Array:
    """(N,) how far the CoM's projection lies inside the support polygon, m."""
    hulls = {phase: hull(contact_points(biped, phase)) for phase in samples.phases}
    return np.array(
        [inside(hulls[phase], com[:2, None])[0] for phase, com in zip(samples.phases, samples.com, strict=True)]
    )


def _yaw_joints(robot: Robot) -> list[int]:
    """The joints of the legs that turn about the vertical at zero angles."""
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    return [int(joint) for leg in robot.legs for joint in leg.joint_indices if abs(data.xaxis[1 + joint, 2]) > _UPRIGHT]


def _largest(samples: Samples, joints: list[int]) -> tuple[int, int, float]:
    """Instant, joint and size of the largest torque of some joints, N·m."""
    torque = np.abs(samples.torque[:, joints])
    instant, joint = (int(k) for k in np.unravel_index(int(torque.argmax()), torque.shape))
    return instant, joints[joint], float(torque[instant, joint])


def paper_claims(static: Gait, dynamic: Gait, robot: Robot) -> list[Claim]:
    """Every claim of section 5 for a static (0.15 m/s) and a dynamic (0.40 m/s) cyclic gait.

    Args:
        static: the slow gait.
        dynamic: the fast gait.
        robot: the robot of both.
    """
    biped, legs = biped_from(robot), robot.legs
    slow, fast = (
        UnrolledGait(gait, robot, 1).at(np.linspace(0.0, gait.duration, _SAMPLES)) for gait in (static, dynamic)
    )
    away = [float(np.sqrt(np.mean(np.sum((t.zmp - t.com[:, :2]) ** 2, axis=1)))) * 1e3 for t in (slow, fast)]
    found = [
        Claim(
            "static walking: the ZMP overlaps with the CoG",
            f"rms distance {away[0]:.1f} mm (dynamic: {away[1]:.1f} mm)",
            away[0] < 0.5 * away[1] and away[0] < 25.0,
        )
    ]
    margin = verify(dynamic, robot, 200).hull_margin
    outside = -1e3 * float(_inside(fast, biped).min())
    found.append(
        Claim(
            "dynamic walking: the CoG leaves the stable region, the ZMP stays inside",
            f"CoG up to {outside:.1f} mm outside, ZMP at least {margin:.1f} mm inside",
            outside > 0.0 and margin > 0.0,
        )
    )
    depth = 1e3 * float(_inside(slow, biped).min())
    found.append(Claim("static walking: the CoG stays inside", f"at least {depth:.1f} mm inside", depth > 0.0))
    knees, ankles = {leg.knee for leg in legs}, {joint for leg in legs for joint in (leg.ankle_roll, leg.ankle_pitch)}
    yaw = _yaw_joints(robot)
    for kind, samples, said, wanted in (("static", slow, "knee", knees), ("dynamic", fast, "ankle", ankles)):
        instant, joint, value = _largest(samples, list(range(len(robot.joint_names))))
        text = f"{robot.joint_names[joint]}, {value:.1f} N·m, in {samples.phases[instant].name}"
        found.append(Claim(f"{kind} walking: the largest torque is in the support {said}", text, joint in wanted))
    for kind, samples in (("static", slow), ("dynamic", fast)):
        instant, _, value = _largest(samples, yaw)
        text = f"peak {value:.2f} N·m in {samples.phases[instant].name}"
        text += " (the paper: 12 N·m, from single to double support)" if kind == "dynamic" else ""
        found.append(Claim(f"{kind} walking: the hip yaw torque is not zero", text, value > 0.1))
    for kind, gait in (("static", static), ("dynamic", dynamic)):
        jump = verify(gait, robot, 100).torque_jump
        text = f"largest jump {jump:.1e} N·m"
        found.append(Claim(f"{kind} walking: torques are continuous and smooth", text, jump < 0.01))
    lean = [float(np.ptp(t.com[:, 1])) * 1e3 for t in (slow, fast)]
    text = f"CoG sways {lean[0]:.1f} mm static, {lean[1]:.1f} mm dynamic"
    found.append(Claim("lateral motion matters more in static walking", text, lean[0] > lean[1]))
    return found
