"""The paper's claims about its two cyclic gaits (section 5), each with our figure and a verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.synthesis.gaits.full_state import StateFinder
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.support import contact_points, hull, inside, zmp
from gaitsmith.synthesis.proof.verify import verify

Array = npt.NDArray[np.float64]
_SAMPLES = 200


@dataclass(frozen=True)
class Claim:
    """One claim: the paper's words in short, what we find, and whether it holds here."""

    claim: str
    found: str
    holds: bool

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return dict(vars(self))


@dataclass(frozen=True, eq=False)
class _Traces:
    """A gait sampled: phase, ZMP and CoM on the ground (2, N), torques (n, N), CoM's distance inside the hull (N,)."""

    phase: list[str]
    zmp: Array
    com: Array
    torque: Array
    inside: Array
    single: Array


def _traces(gait: Gait, robot: Robot) -> _Traces:
    from gaitsmith.synthesis.motions.biped import biped_from

    finder, biped, borders = StateFinder(robot), biped_from(robot), gait.motion.borders
    names: list[str] = []
    parts: dict[str, list[Array]] = {key: [] for key in ("zmp", "com", "torque", "inside", "single")}
    for index, phase in enumerate(gait.motion.phases):
        times = np.linspace(borders[index], borders[index + 1], _SAMPLES)
        q, v, a = gait.joints(index, times)
        com = np.zeros((2, _SAMPLES))
        for k in range(_SAMPLES):
            finder.find(phase.support, phase.foothold, q[:, k], v[:, k], a[:, k])
            com[:, k] = finder.centre_of_mass()[:2]
        names += [phase.name] * _SAMPLES
        parts["zmp"].append(zmp(phase, gait.wrenches(index, times)))
        parts["com"].append(com)
        parts["torque"].append(gait.torques(index, times))
        parts["inside"].append(inside(hull(contact_points(biped, phase)), com))
        parts["single"].append(np.full(_SAMPLES, not phase.double))
    stacked = {key: np.concatenate(value, axis=-1) for key, value in parts.items()}
    return _Traces(names, **stacked)


def paper_claims(static: Gait, dynamic: Gait, robot: Robot) -> list[Claim]:
    """Every claim of section 5 for a static (0.15 m/s) and a dynamic (0.40 m/s) cyclic gait.

    Args:
        static: the slow gait.
        dynamic: the fast gait.
        robot: the robot of both.
    """
    slow, fast = _traces(static, robot), _traces(dynamic, robot)
    away = [float(np.sqrt(np.mean(np.sum((t.zmp - t.com) ** 2, axis=0)))) * 1e3 for t in (slow, fast)]
    found = [
        Claim(
            "static walking: the ZMP overlaps with the CoG",
            f"rms distance {away[0]:.1f} mm (dynamic: {away[1]:.1f} mm)",
            away[0] < 0.5 * away[1] and away[0] < 25.0,
        )
    ]
    margin = verify(dynamic, robot, 200).hull_margin
    outside = -1e3 * float(fast.inside.min())
    found.append(
        Claim(
            "dynamic walking: the CoG leaves the stable region, the ZMP stays inside",
            f"CoG up to {outside:.1f} mm outside, ZMP at least {margin:.1f} mm inside",
            outside > 0.0 and margin > 0.0,
        )
    )
    inside = 1e3 * float(slow.inside.min())
    found.append(Claim("static walking: the CoG stays inside", f"at least {inside:.1f} mm inside", inside > 0.0))
    names = list(robot.joint_names)
    for kind, trace, wanted in (("static", slow, ("knee",)), ("dynamic", fast, ("ankle_roll", "ankle_pitch"))):
        place = np.unravel_index(int(np.argmax(np.abs(trace.torque))), trace.torque.shape)
        joint, phase = names[int(place[0])], trace.phase[int(place[1])]
        value = float(np.abs(trace.torque[place]))
        said = "the support knee" if kind == "static" else "the support ankle"
        found.append(
            Claim(
                f"{kind} walking: the largest torque is in {said}",
                f"{joint}, {value:.1f} N·m, in {phase}",
                joint.endswith(wanted),
            )
        )
    yaw = [k for k, name in enumerate(names) if name.endswith("hip_yaw")]
    for kind, trace in (("static", slow), ("dynamic", fast)):
        peak = float(np.abs(trace.torque[yaw]).max())
        place = np.unravel_index(int(np.argmax(np.abs(trace.torque[yaw]))), (len(yaw), trace.torque.shape[1]))
        text = f"peak {peak:.2f} N·m in {trace.phase[int(place[1])]}"
        text += " (the paper: 12 N·m, from single to double support)" if kind == "dynamic" else ""
        found.append(Claim(f"{kind} walking: the hip yaw torque is not zero", text, peak > 0.1))
    for kind, gait in (("static", static), ("dynamic", dynamic)):
        jump = verify(gait, robot, 100).torque_jump
        text = f"largest jump {jump:.1e} N·m"
        found.append(Claim(f"{kind} walking: torques are continuous and smooth", text, jump < 0.01))
    lean = [float(np.ptp(t.com[1])) * 1e3 for t in (slow, fast)]
    text = f"CoG sways {lean[0]:.1f} mm static, {lean[1]:.1f} mm dynamic"
    found.append(Claim("lateral motion matters more in static walking", text, lean[0] > lean[1]))
    return found
