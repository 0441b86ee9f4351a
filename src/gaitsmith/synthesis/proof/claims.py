"""The paper's claims about its two cyclic gaits (section 5, every sentence), each with our figure and a verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.support import depths
from gaitsmith.synthesis.gaits.unrolled import Samples, UnrolledGait
from gaitsmith.synthesis.motions.biped import Biped, biped_from
from gaitsmith.synthesis.proof.verify import verify

Array = npt.NDArray[np.float64]
_SAMPLES = 1200
_UPRIGHT = 0.9  # cosine
_THIN = 8  # every so many samples
_YAW = 12.0  # N·m
_NEAR, _ROUGH = 0.05, 5.0  # of a step; times as fast
_LONGER = 1.5  # times


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
    return depths(biped, samples.phases, samples.com[:, :2])


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


def _pitch(samples: Samples) -> Array:
    """(N,) pitch of the torso, degrees; forward is positive."""
    w, x, y, z = samples.position[:, 3:7].T
    return np.asarray(np.degrees(np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0))))


def _swing(gait: Gait, biped: Biped, robot: Robot) -> tuple[float, float]:
    """Of the first swing: the share of it with the ankle above 90 % of its rise, and its fastest fall, m/s."""
    count = int(np.argmax([phase.double for phase in gait.motion.phases]))
    times = np.linspace(0.0, gait.motion.borders[count], _SAMPLES)
    samples, data = UnrolledGait(gait, robot, 1).at(times), mujoco.MjData(robot.model)
    body = robot.legs[0 if gait.motion.phases[0].other_foot == "left" else 1].sole_body
    heights = np.zeros(len(times))
    for k, position in enumerate(samples.position):
        data.qpos[:] = position
        mujoco.mj_kinematics(robot.model, data)
        heights[k] = data.xpos[body][2] - biped.ankle_height
    return float(np.mean(heights > 0.9 * heights.max())), float(-np.gradient(heights, times).min())


def _inertial(samples: Samples, robot: Robot) -> float:
    """In single support, the root mean square of what torques bear besides weight, as a share of all of it."""
    model, data = robot.model, mujoco.MjData(robot.model)
    still, jacobian, moving = np.zeros(model.nv), np.zeros((6, model.nv)), []
    single = [k for k, phase in enumerate(samples.phases) if not phase.double]
    for k in single[::_THIN]:
        data.qpos[:], data.qvel[:] = samples.position[k], 0.0
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_rne(model, data, 0, still)
        site = data.site(robot.legs[0 if samples.phases[k].support == "left" else 1].sole_site).id
        mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
        wrench = np.linalg.solve(jacobian[:, :6].T, still[:6])
        moving.append(samples.torque[k] - (still - jacobian.T @ wrench)[6:])
    whole = samples.torque[single[::_THIN]]
    return float(np.linalg.norm(moving) / np.linalg.norm(whole))


def _fluctuation(samples: Samples, times: Array) -> float:
    """Largest acceleration of the ZMP near a change from single to double support, over its median elsewhere."""
    double = np.array([phase.double for phase in samples.phases])
    changes = times[np.flatnonzero(~double[:-1] & double[1:])]
    bend = np.linalg.norm(np.gradient(np.gradient(samples.zmp, times, axis=0), times, axis=0), axis=1)
    near = np.abs(times[:, None] - changes).min(axis=1) < _NEAR * times[-1]
    return float(bend[near].max() / np.median(bend[~near]))


def paper_claims(static: Gait, dynamic: Gait, robot: Robot) -> list[Claim]:
    """Every claim of section 5 for a static (0.15 m/s) and a dynamic (0.40 m/s) cyclic gait.

    Args:
        static: the slow gait.
        dynamic: the fast gait.
        robot: the robot of both.
    """
    biped, legs = biped_from(robot), robot.legs
    times = [np.linspace(0.0, gait.duration, _SAMPLES) for gait in (static, dynamic)]
    slow, fast = (UnrolledGait(gait, robot, 1).at(at) for gait, at in zip((static, dynamic), times, strict=True))
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
    yaw_peak = _largest(fast, yaw)[2]
    said = "dynamic walking: the hip yaw torque reaches 12 N·m from single to double support"
    found.append(Claim(said, f"{yaw_peak:.2f} N·m", yaw_peak >= _YAW))
    shares = [_inertial(samples, robot) for samples in (slow, fast)]
    text = f"{100 * shares[0]:.0f} % of the torques static, {100 * shares[1]:.0f} % dynamic, in single support"
    found.append(Claim("dynamic walking: inertia and Coriolis forces are overcome", text, shares[1] > shares[0]))
    lean = [float(np.ptp(t.com[:, 1])) * 1e3 for t in (slow, fast)]
    text = f"CoG sways {lean[0]:.1f} mm static, {lean[1]:.1f} mm dynamic"
    found.append(Claim("lateral motion matters more in static walking", text, lean[0] > lean[1]))
    rough = _fluctuation(fast, times[1])
    text = f"it changes speed {rough:.0f} times as fast there as elsewhere"
    found.append(Claim("the ZMP fluctuates from single to double support", text, rough > _ROUGH))
    return _of_figure_4(static, dynamic, slow, fast, biped, robot) + found


def _of_figure_4(static: Gait, dynamic: Gait, slow: Samples, fast: Samples, biped: Biped, robot: Robot) -> list[Claim]:
    """What the paper reads off its stick figures."""
    angles = [float(np.mean(_pitch(samples))) for samples in (slow, fast)]
    text = f"mean pitch {angles[0]:.1f}° static, {angles[1]:.1f}° dynamic"
    found = [Claim("dynamic walking has a bigger body angle", text, angles[1] > angles[0])]
    steps = [gait.motion.parameters["length"] for gait in (static, dynamic)]
    text = f"{steps[0]:.2f} m static, {steps[1]:.2f} m dynamic, as asked"
    found.append(Claim("dynamic walking has a bigger step size", text, steps[1] > steps[0]))
    (share, fall), (other, faster) = (_swing(gait, biped, robot) for gait in (static, dynamic))
    text = f"above 90 % of its rise for {100 * share:.0f} % of the swing static, {100 * other:.0f} % dynamic"
    found.append(Claim("static walking: the swing foot holds a while at its highest", text, share > _LONGER * other))
    text = f"down at up to {fall:.2f} m/s static, {faster:.2f} m/s dynamic"
    found.append(Claim("dynamic walking: the swing foot sharply moves back", text, faster > _LONGER * fall))
    high = [verify(gait, robot, 100).clearance for gait in (static, dynamic)]
    text = f"sole at least {high[0]:.1f} mm up in the middle half of the swing static, {high[1]:.1f} mm dynamic"
    found.append(Claim("static walking steps over obstacles better", text, high[0] > high[1]))
    return found
