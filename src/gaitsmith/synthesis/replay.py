"""A gait replayed in MuJoCo: joint PD, planned torque, and an ankle that corrects the torso's attitude."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.robots import Robot
from gaitsmith.robots.parameters import NonNegative, Parameters, Positive
from gaitsmith.synthesis.biped import biped_from
from gaitsmith.synthesis.full_state import StateFinder
from gaitsmith.synthesis.gait import Gait, unrolled
from gaitsmith.synthesis.support import zmp

Array = npt.NDArray[np.float64]
_TICK, _SUBSTEPS = 1e-3, 2  # s between control ticks, physics steps in each
_FALLEN_TILT, _FALLEN_HEIGHT = np.radians(45.0), 0.6
_SOLREF = (0.005, 1.0)
_SAMPLE = 10  # ticks between records
BALL_RADIUS, BALL_MASS = 0.05, 0.2


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


class _Reference:
    """The plan sampled at every control tick."""

    def __init__(self, robot: Robot, gait: Gait, settle: float) -> None:
        borders = gait.motion.borders
        count = round(float(borders[-1]) / _TICK)
        times: Array = np.arange(count + 1, dtype=np.float64) * _TICK
        n = len(gait.joint_names)
        self.phase = np.clip(np.searchsorted(borders, times, side="right") - 1, 0, len(borders) - 2)
        self.q, self.v, self.a = np.zeros((count + 1, n)), np.zeros((count + 1, n)), np.zeros((count + 1, n))
        self.torque, self.zmp = np.zeros((count + 1, n)), np.zeros((count + 1, 2))
        for index, phase in enumerate(gait.motion.phases):
            mask = np.flatnonzero(self.phase == index)
            if len(mask) == 0:
                continue
            q, v, a = gait.joints(index, times[mask])
            self.q[mask], self.v[mask], self.a[mask] = q.T, v.T, a.T
            self.torque[mask] = gait.torques(index, times[mask]).T
            self.zmp[mask] = zmp(phase, gait.wrenches(index, times[mask])).T
        self.hold = int(settle / _TICK) if np.abs(self.v[-1]).max() < 1e-6 else 0
        self.ticks = count + self.hold
        finder = StateFinder(robot)
        self.base, self.spin = np.zeros((count + 1, 7)), np.zeros((count + 1, 3))
        for k in range(count + 1):
            phase = gait.motion.phases[self.phase[k]]
            state = finder.find(phase.support, phase.foothold, self.q[k], self.v[k], self.a[k])
            self.base[k], self.spin[k] = state.position[:7], state.velocity[3:6]
            if k == 0:
                self.start = state


def _model(robot: Robot, gait: Gait, settings: ReplaySettings) -> Any:
    """The robot on a plane, with the ball of a kick."""
    spec = robot.make_spec()
    spec.option.timestep = _TICK / _SUBSTEPS
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    ground = spec.worldbody.add_geom()
    ground.name, ground.type = "ground", mujoco.mjtGeom.mjGEOM_PLANE
    ground.size, ground.priority, ground.condim = [50.0, 50.0, 0.1], 1, 4
    ground.friction, ground.solref = [settings.friction, 0.005, 0.0001], list(_SOLREF)
    ground.contype, ground.conaffinity = 1, 0x7FFFFFFF
    if gait.motion.name == "kick":
        sole, parameters = robot.legs[0].sole, gait.motion.parameters
        place = [parameters["ball_1"] + sole.toe + BALL_RADIUS, parameters["ball_2"], BALL_RADIUS]
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
    """
    settings = settings or ReplaySettings()
    biped = biped_from(robot)
    whole = unrolled(gait, biped.partner, biped.sign, steps)
    plan = _Reference(robot, whole, settings.settle)
    model = _model(robot, gait, settings)
    data = mujoco.MjData(model)
    nq, nv, n = robot.model.nq, robot.model.nv, biped.joints
    data.qpos[:nq], data.qvel[:nv] = plan.start.position, plan.start.velocity
    mujoco.mj_forward(model, data)
    kp, kd = settings.stiffness * settings.gain_scale, settings.damping * settings.gain_scale
    limit = np.asarray(robot.torque_limit)
    ankles = {leg.name: (leg.ankle_pitch, leg.ankle_roll) for leg in robot.legs}
    actuators = np.asarray(robot.actuators)
    peak, tilt, clipped = np.zeros(n), np.zeros(2), 0
    errors, margins = [], []
    fall: dict[str, Any] | None = None
    trace: dict[str, list[Any]] = {"time": [], "torso": [], "zmp": []}
    ball_speed, last = 0.0, len(plan.q) - 1
    begin_x, time = float(data.qpos[0]), 0.0
    for tick in range(plan.ticks):
        k = min(tick, last)
        time = tick * _TICK
        phase = whole.motion.phases[plan.phase[k]]
        away = _deviation(plan.base[k, 3:7], data.qpos[3:7])
        spin = data.qvel[3:6] - plan.spin[k]
        goal = plan.q[k].copy()
        for side in ("left", "right") if phase.contact == "flat" else (phase.support,):
            pitch, roll = ankles[side]
            goal[pitch] += settings.attitude_gain * away[1] + settings.attitude_damping * spin[1]
            if roll >= 0:
                goal[roll] += settings.attitude_gain * away[0] + settings.attitude_damping * spin[0]
        torque = plan.torque[k] + kp * (goal - data.qpos[7:nq]) + kd * (plan.v[k] - data.qvel[6:nv])
        sent = np.clip(torque, -limit, limit)
        clipped += bool((sent != torque).any())
        peak = np.maximum(peak, np.abs(sent))
        data.ctrl[actuators] = sent
        for _ in range(_SUBSTEPS):
            mujoco.mj_step(model, data)
        tilt = np.maximum(tilt, np.abs(away[:2]))
        height = float(data.qpos[2] / plan.base[k, 2])
        if not np.isfinite(data.qpos).all() or np.abs(away[:2]).max() > _FALLEN_TILT or height < _FALLEN_HEIGHT:
            what = "torso tilt beyond 45 degrees" if np.abs(away[:2]).max() > _FALLEN_TILT else "torso too low"
            fall = {"time": time, "reason": f"{what} in {phase.name}", "phase": phase.name}
            break
        if tick % _SAMPLE == 0:
            real = _real_zmp(model, data)
            trace["time"].append(time)
            trace["torso"].append(data.qpos[:3].tolist())
            trace["zmp"].append(None if real is None else real.tolist())
            if real is not None:
                errors.append(float(np.sum((real - plan.zmp[k]) ** 2)))
                if not phase.double:
                    margins.append(_sole_margin(robot, phase.support, data, model, real))
            if report is not None:
                report(time, plan.ticks * _TICK)
        if gait.motion.name == "kick":
            ball_speed = max(ball_speed, float(np.linalg.norm(data.qvel[nv : nv + 3])))
    k = min(plan.ticks, last)
    ball = None
    if gait.motion.name == "kick":
        ball = {"speed": ball_speed, "travel": float(data.qpos[nq] - model.qpos0[nq])}
    return ReplayResult(
        stood=fall is None,
        fall=fall,
        duration=time + _TICK,
        distance=float(data.qpos[0]) - begin_x,
        planned_distance=float(plan.base[k, 0]) - begin_x,
        drift=abs(float(data.qpos[1] - plan.base[k, 1])),
        tilt_deg={"roll": float(np.degrees(tilt[0])), "pitch": float(np.degrees(tilt[1]))},
        zmp_error_mm=1e3 * float(np.sqrt(np.mean(errors))) if errors else 0.0,
        zmp_margin_mm=1e3 * float(np.percentile(margins, 5.0)) if margins else 0.0,
        torque_peak=dict(zip(robot.joint_names, peak.tolist(), strict=True)),
        torque_saturated=clipped / max(plan.ticks, 1),
        ball=ball,
        trace=trace,
    )


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
