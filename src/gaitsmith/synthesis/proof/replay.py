"""A gait replayed in MuJoCo: joint PD, planned torque, and an ankle that corrects the torso's attitude."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot
from gaitsmith.robots.parameters import NonNegative, Parameters, Positive
from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.unrolled import UnrolledGait
from gaitsmith.synthesis.motions.motion import Phase

Array = npt.NDArray[np.float64]
_TICK, _SUBSTEPS = 1e-3, 2  # s between control ticks, physics steps in each
_FALLEN_TILT, _FALLEN_HEIGHT = np.radians(45.0), 0.6
_SOLREF = (0.005, 1.0)
_SAMPLE = 10  # ticks between records
_BLOCK = 1000  # ticks of the plan computed at a time
_RESTING = 1e-6  # rad/s
BALL_RADIUS, BALL_MASS = 0.05, 0.2
_BALL_RANGE = 2.0  # m


class ReplaySettings(Parameters):
    """How a gait is replayed.

    Attributes:
        stiffness: of every joint, N·m/rad.
        damping: N·m·s/rad.
        attitude_gain: angle of the ankle per angle of the torso's deviation from the plan.
        attitude_damping: angle of the ankle per rad/s of the torso's deviation, s.
        friction: Coulomb coefficient between sole and ground.
        mass_scale: by which every mass and inertia of the real robot differs from the planned one.
        gain_scale: by which stiffness and damping differ from what is set here.
        settle: s for which the last posture of a motion that ends at rest is held.
    """

    stiffness: Positive = 300.0
    damping: Positive = 6.0
    attitude_gain: NonNegative = 0.5
    attitude_damping: NonNegative = 0.0
    friction: Positive = 0.8
    mass_scale: Positive = 1.0
    gain_scale: Positive = 1.0
    settle: NonNegative = 2.0


@dataclass(eq=False)
class ReplayResult:
    """What came of a replay.

    Attributes:
        stood: whether the robot was upright to the end.
        fall: None, or the time and what was exceeded.
        duration: simulated, s.
        distance: travelled by the torso along x, m.
        planned_distance: the same by the plan, m.
        drift: lateral distance from the plan at the end, m.
        tilt_deg: largest deviation of roll and pitch from the plan, degrees.
        zmp_error_mm: root mean square distance of the real ZMP from the planned one, mm.
        zmp_margin_mm: 5th percentile of the real ZMP's distance from the support sole's edge in single support, mm.
        torque_peak: of every joint, N·m.
        torque_saturated: share of ticks at which a torque was clipped.
        ball: None, or speed (m/s) and travel (m) of the ball.
        trace: sampled time, torso position and real ZMP.
    """

    stood: bool
    fall: dict[str, Any] | None
    duration: float
    distance: float
    planned_distance: float
    drift: float
    tilt_deg: dict[str, float]
    zmp_error_mm: float
    zmp_margin_mm: float
    torque_peak: dict[str, float]
    torque_saturated: float
    ball: dict[str, float] | None
    trace: dict[str, list[Any]] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {key: value for key, value in vars(self).items() if key != "trace"}


@dataclass(frozen=True, eq=False)
class _Wanted:
    """The plan at one tick: phase, state, torque and ZMP."""

    phase: Phase
    position: Array
    velocity: Array
    torque: Array
    zmp: Array


class _Plan:
    """The plan at every control tick, computed a block of ticks at a time; its end is held for a while if at rest."""

    def __init__(self, whole: UnrolledGait, settle: float) -> None:
        self._whole = whole
        self.last = round(whole.duration / _TICK)
        self._first = -1
        self.ticks = self.last
        self.ticks += int(settle / _TICK) if np.abs(self.at(self.last).velocity[6:]).max() < _RESTING else 0

    def at(self, tick: int) -> _Wanted:
        """What is planned at a tick; beyond the end, what is planned there."""
        tick = min(tick, self.last)
        k = tick % _BLOCK
        if tick - k != self._first:
            self._first = tick - k
            times = np.arange(self._first, min(self._first + _BLOCK, self.last + 1)) * _TICK
            self._block = self._whole.at(np.minimum(times, self._whole.duration))
        found = self._block
        return _Wanted(found.phases[k], found.position[k], found.velocity[k], found.torque[k], found.zmp[k])


def _ball(gait: Gait) -> tuple[float, float] | None:
    """Where the ankle meets the ball by the gait's parameters, m; None for a gait without one.

    Raises:
        BadInput: a place that no kick reaches.
    """
    found = [gait.motion.parameters.get(key) for key in ("ball_1", "ball_2")]
    if found[0] is None or found[1] is None:
        return None
    for key, value in zip(("ball_1", "ball_2"), found, strict=True):
        if value is None or not abs(value) <= _BALL_RANGE:
            raise BadInput(f"parameters.{key}", value, f"-{_BALL_RANGE:g} to {_BALL_RANGE:g} m", "plan it again")
    return found[0], found[1]


@contextmanager
def _quiet() -> Iterator[None]:
    """MuJoCo's warnings go nowhere, instead of a log file in the working folder: a fall says what happened."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)


def _model(robot: Robot, target: tuple[float, float] | None, settings: ReplaySettings) -> Any:
    """The robot on a plane, with the ball of a kick."""
    spec = robot.make_spec()
    spec.option.timestep = _TICK / _SUBSTEPS
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    ground = spec.worldbody.add_geom()
    ground.name, ground.type = "ground", mujoco.mjtGeom.mjGEOM_PLANE
    ground.size, ground.priority, ground.condim = [50.0, 50.0, 0.1], 1, 4
    ground.friction, ground.solref = [settings.friction, 0.005, 0.0001], list(_SOLREF)
    ground.contype, ground.conaffinity = 1, 0x7FFFFFFF
    if target is not None:
        place = [target[0] + robot.legs[0].sole.toe + BALL_RADIUS, target[1], BALL_RADIUS]
        ball = spec.worldbody.add_body(name="ball", pos=place)
        ball.add_freejoint(name="ball")
        ball.mass, ball.explicitinertial = BALL_MASS, True
        ball.ipos, ball.iquat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
        ball.inertia = [0.4 * BALL_MASS * BALL_RADIUS**2] * 3
        shape = ball.add_geom()
        shape.name, shape.type, shape.size = "ball", mujoco.mjtGeom.mjGEOM_SPHERE, [BALL_RADIUS, 0.0, 0.0]
        shape.contype, shape.conaffinity = 1, 0x7FFFFFFF
        shape.friction, shape.solref = [0.6, 0.005, 0.0001], list(_SOLREF)
    model = spec.compile()
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    # The ball's joint takes the robot's defaults for joints, which are not its own.
    model.dof_armature[robot.model.nv :] = 0.0
    model.dof_damping[robot.model.nv :] = 0.0
    model.body_mass[1 : robot.model.nbody] *= settings.mass_scale
    model.body_inertia[1 : robot.model.nbody] *= settings.mass_scale
    return model


def replay(
    gait: Gait,
    robot: Robot,
    settings: ReplaySettings | None = None,
    steps: int = 20,
    report: Callable[[float, float], None] | None = None,
) -> ReplayResult:
    """Replay a gait.

    Args:
        gait: the gait; a cyclic one is repeated.
        robot: the robot that it was planned for.
        settings: gains, friction and errors of the model.
        steps: of a cyclic gait.
        report: told the simulated and the whole time, s.

    Raises:
        BadInput: more than an hour of steps, or a kick at a ball that is out of reach.
    """
    with _quiet():
        return _replayed(gait, robot, settings or ReplaySettings(), steps, report)


def _replayed(
    gait: Gait, robot: Robot, settings: ReplaySettings, steps: int, report: Callable[[float, float], None] | None
) -> ReplayResult:
    plan, target = _Plan(UnrolledGait(gait, robot, steps), settings.settle), _ball(gait)
    model = _model(robot, target, settings)
    data = mujoco.MjData(model)
    nq, nv, n = robot.model.nq, robot.model.nv, len(robot.joint_names)
    start = plan.at(0)
    data.qpos[:nq], data.qvel[:nv] = start.position, start.velocity
    mujoco.mj_forward(model, data)
    kp, kd = settings.stiffness * settings.gain_scale, settings.damping * settings.gain_scale
    limit = np.asarray(robot.torque_limit)
    ankles = {leg.name: (leg.ankle_pitch, leg.ankle_roll) for leg in robot.legs}
    actuators = np.asarray(robot.actuators)
    peak, tilt, clipped = np.zeros(n), np.zeros(2), 0
    errors, margins = [], []
    fall: dict[str, Any] | None = None
    trace: dict[str, list[Any]] = {"time": [], "torso": [], "zmp": []}
    ball_speed, begin_x, time = 0.0, float(data.qpos[0]), 0.0
    for tick in range(plan.ticks):
        time, wanted = tick * _TICK, plan.at(tick)
        phase = wanted.phase
        away = _deviation(wanted.position[3:7], data.qpos[3:7])
        spin = data.qvel[3:6] - wanted.velocity[3:6]
        goal = wanted.position[7:].copy()
        for side in ("left", "right") if phase.contact == "flat" else (phase.support,):
            pitch, roll = ankles[side]
            goal[pitch] += settings.attitude_gain * away[1] + settings.attitude_damping * spin[1]
            if roll >= 0:
                goal[roll] += settings.attitude_gain * away[0] + settings.attitude_damping * spin[0]
        torque = wanted.torque + kp * (goal - data.qpos[7:nq]) + kd * (wanted.velocity[6:] - data.qvel[6:nv])
        if not np.isfinite(torque).all():
            fall = {"time": time, "reason": f"torque that is not a number in {phase.name}", "phase": phase.name}
            break
        sent = np.clip(torque, -limit, limit)
        clipped += bool((sent != torque).any())
        peak = np.maximum(peak, np.abs(sent))
        data.ctrl[actuators] = sent
        for _ in range(_SUBSTEPS):
            mujoco.mj_step(model, data)
        tilt = np.maximum(tilt, np.abs(away[:2]))
        height = float(data.qpos[2] / wanted.position[2])
        what = _fallen(data, away, height)
        if what:
            fall = {"time": time, "reason": f"{what} in {phase.name}", "phase": phase.name}
            break
        if tick % _SAMPLE == 0:
            real = _real_zmp(model, data)
            trace["time"].append(time)
            trace["torso"].append(data.qpos[:3].tolist())
            trace["zmp"].append(None if real is None else real.tolist())
            if real is not None:
                errors.append(float(np.sum((real - wanted.zmp) ** 2)))
                if not phase.double:
                    margins.append(_sole_margin(robot, phase.support, data, model, real))
            if report is not None:
                report(time, plan.ticks * _TICK)
        if target is not None:
            ball_speed = max(ball_speed, float(np.linalg.norm(data.qvel[nv : nv + 3])))
    end, ball = plan.at(plan.ticks).position, None
    if target is not None:
        ball = {"speed": ball_speed, "travel": float(data.qpos[nq] - model.qpos0[nq])}
    return ReplayResult(
        stood=fall is None,
        fall=fall,
        duration=time + _TICK,
        distance=float(data.qpos[0]) - begin_x,
        planned_distance=float(end[0]) - begin_x,
        drift=abs(float(data.qpos[1] - end[1])),
        tilt_deg={"roll": float(np.degrees(tilt[0])), "pitch": float(np.degrees(tilt[1]))},
        zmp_error_mm=1e3 * float(np.sqrt(np.mean(errors))) if errors else 0.0,
        zmp_margin_mm=1e3 * float(np.percentile(margins, 5.0)) if margins else 0.0,
        torque_peak=dict(zip(robot.joint_names, peak.tolist(), strict=True)),
        torque_saturated=clipped / max(plan.ticks, 1),
        ball=ball,
        trace=trace,
    )


def _fallen(data: Any, away: Array, height: float) -> str:
    """What a fall is known by, in words; empty while the robot is upright."""
    if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
        return "simulation diverged"
    if not np.abs(away[:2]).max() <= _FALLEN_TILT:
        return "torso tilt beyond 45 degrees"
    return "torso too low" if not height >= _FALLEN_HEIGHT else ""


def _deviation(wanted: Array, real: Array) -> Array:
    """Small rotation (3,) from the planned to the real attitude, body axes, rad."""
    inverse = wanted * np.array([1.0, -1.0, -1.0, -1.0])
    product = np.zeros(4)
    mujoco.mju_mulQuat(product, inverse, np.asarray(real))
    return np.asarray(2.0 * product[1:] * (1.0 if product[0] >= 0.0 else -1.0))


def _real_zmp(model: Any, data: Any) -> Array | None:
    """(2,) centre of the vertical contact forces between robot and ground; None without contact."""
    ground = model.geom("ground").id
    ball = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, "ball")
    total, moment, force = 0.0, np.zeros(2), np.zeros(6)
    for index in range(data.ncon):
        contact = data.contact[index]
        pair = (contact.geom[0], contact.geom[1])
        if ground not in pair or ball in pair:
            continue
        mujoco.mj_contactForce(model, data, index, force)
        total += float(force[0])
        moment += float(force[0]) * contact.pos[:2]
    return moment / total if total > 1.0 else None


def _sole_margin(robot: Robot, side: str, data: Any, model: Any, point: Array) -> float:
    """Distance of a point on the ground from the edge of a sole, inside positive, m."""
    leg = robot.legs[0 if side == "left" else 1]
    site = model.site(leg.sole_site).id
    local = data.site_xmat[site].reshape(3, 3).T @ (np.array([*point, 0.0]) - data.site_xpos[site])
    sole = leg.sole
    return float(min(local[0] + sole.heel, sole.toe - local[0], sole.half_width - abs(local[1])))
