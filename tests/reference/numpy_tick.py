"""The control tick in NumPy, written to be read beside the paper (Han 2023) and to hold the compiled tick to it.

Rigid-body quantities come from MuJoCo, splines from the paper's W matrix, quadratic programs from DAQP; no kernel of
the package is called.
"""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt
from tests.reference.memory import LEFT, RIGHT, GaitNumbers, Memory
from tests.reference.quadratic_program import minimise
from tests.reference.rigid_body import Instant, RigidBody
from tests.reference.whole_body import Wishes, solve_whole_body

from gaitsmith.control import Measurement
from gaitsmith.robots import Leg, Robot
from gaitsmith.robots.parameters import ControlParameters, JointGains
from gaitsmith.splines import coefficients, time_vectors

Array = npt.NDArray[np.float64]

DT = 1e-3  # s
GRAVITY = 9.81  # m/s²
HEIGHT_RATE = 0.15  # m/s, while standing
STRADDLE = 0.06  # m, soles at most this far apart lengthwise when a walk ends
SETTLED = 0.05  # m/s, slow enough to keep a station
LOWEST_COM = 0.05  # m, of the pendulum
SETTLING = 3  # steps that a new speed takes to show
SLIP = 0.1  # m/s, largest error that the integral learns from
DURATIONS = (0.8, 1.1)  # of the period, shortest and longest step that says something about the next
DECAY = 0.98  # of the torque at a tick that cannot be computed

TURNS = {4: [1], 6: [0, 1, 2]}  # sole axes that a leg of so many joints can turn about besides placing the sole


def curve(t: float, gait: GaitNumbers, start: Array, middle: float, end: float) -> Array:
    """Eqs. 1-6 and 14: position, velocity, acceleration; at rest at ``end`` from T on."""
    if t > gait.period:
        return np.array([end, 0.0, 0.0])
    joint = gait.alpha * gait.period
    xi = coefficients(0.0, joint, gait.period, np.array([*start, middle, end, 0.0, 0.0, middle, 0.0, 0.0]))
    return time_vectors(t) @ (xi[:5] if t < joint else xi[5:])


class NumpyTick:
    """Reference of :class:`gaitsmith.Controller`.

    Args:
        robot: the robot.
        parameters: the preset.
        joint_gains: eq. 27; those for the true state if None.
    """

    def __init__(self, robot: Robot, parameters: ControlParameters, joint_gains: JointGains | None = None) -> None:
        self.robot, self.parameters = robot, parameters
        self.joint_gains = parameters.joint_gains if joint_gains is None else joint_gains
        self.body = RigidBody(robot)
        self.press = [self._pressing(leg) for leg in robot.legs]
        self.memory: Memory

    def tick(self, measurement: Measurement, requested: GaitNumbers) -> Array:
        """Torques (nj,) of one tick; ``memory`` goes on by one tick."""
        memory, limit = self.memory, self.robot.torque_limit
        q = np.concatenate([measurement.base_position, measurement.base_quaternion, measurement.joint_position])
        v = np.concatenate([measurement.base_velocity, measurement.joint_velocity])
        if not np.isfinite(np.concatenate([q, v, measurement.sole_force])).all():
            memory.torque = np.clip(DECAY * memory.torque, -limit, limit)
            return memory.torque
        now = self.body.at(q, v)
        restarted = self._advance(now, measurement.sole_force, requested)
        for row, leg in enumerate(self.robot.legs):
            if row in restarted or not memory.walking:
                memory.leg_reference[row] = q[7 + leg.joint_indices]
                memory.leg_rate[row] = v[6 + leg.joint_indices]
        if memory.walking:
            self._run_template(now)
            for row in (LEFT, RIGHT):
                self._track_leg(now, row)
        wishes = self.wishes(now, q, v)
        memory.feedforward, memory.acceleration = solve_whole_body(
            self.robot, self.parameters, now, wishes, memory.feedforward
        )
        memory.torque = np.clip(memory.feedforward + self._joint_feedback(q, v), -limit, limit)
        return memory.torque

    def _pressing(self, leg: Leg) -> float:
        """+1 if a positive ankle torque presses the toe down."""
        own = leg.joint_indices
        jacobian = self.body.leg_pose(leg, self.robot.model.qpos0[7 + own])[2]
        return float(np.sign(jacobian[4, list(own).index(leg.ankle_pitch)]))

    # ---- when to step: sections 2.2 and 2.3 ----------------------------------------------------------------------

    def _advance(self, now: Instant, force: Array, requested: GaitNumbers) -> tuple[int, ...]:
        """Advance the step's clock; returns the legs whose references restart from the measured joints."""
        memory = self.memory
        if not memory.walking:
            self._latch(requested)
            if memory.walk_requested:
                self._begin(now, LEFT if requested.speed[1] < 0.0 else RIGHT, from_rest=True)
                memory.walking, memory.settling = True, SETTLING
                return LEFT, RIGHT
            memory.station_kept = False
            change = requested.height - memory.standing_height
            memory.standing_height += float(np.clip(change, -HEIGHT_RATE * DT, HEIGHT_RATE * DT))
            return ()
        memory.step_time += DT
        rule, swing, period = self.parameters.touchdown, 1 - memory.stance, memory.gait.period
        if memory.step_time < rule.earliest * period:
            return ()
        landed = force[swing] > rule.force
        if not landed and memory.step_time <= rule.latest * period:
            return ()
        self._finish_step()
        duration = float(np.clip(memory.step_time / period, *DURATIONS))
        memory.duration_ratio = 0.5 * (memory.duration_ratio + duration)
        self._keep_station(requested)
        self._latch(requested)
        self._begin(now, swing)
        if landed and not memory.walk_requested and self._may_rest(now):
            memory.walking = False
            memory.step_count -= 1
            memory.standing_height = -0.5 * (now.offset(LEFT)[0, 2] + now.offset(RIGHT)[0, 2])
            return ()
        return (1 - memory.stance,)

    def _latch(self, requested: GaitNumbers) -> None:
        """The gait changes only here; a new speed is no bias, so the integral waits."""
        if np.any(requested.speed != self.memory.gait.speed):
            self.memory.settling = SETTLING
        self.memory.gait = requested

    def _begin(self, now: Instant, stance: int, from_rest: bool = False) -> None:
        """Both rules of section 2.2: the support leg goes on from its desired, the swing leg from its actual state."""
        memory, swing = self.memory, 1 - stance
        if from_rest:
            memory.foot_desired[stance] = [now.offset(stance)[0], np.zeros(3), np.zeros(3)]
            memory.station_kept = not memory.gait.speed.any()
            if memory.station_kept:
                memory.station = now.com.position[:2].copy()
        memory.last_duration = 0.0 if from_rest else memory.step_time
        memory.stance, memory.step_time, memory.step_count = stance, 0.0, memory.step_count + 1
        memory.support_start = memory.foot_desired[stance].copy()
        memory.swing_start, memory.swing_pitch_start = now.offset(swing), now.pitch(swing)

    def _finish_step(self) -> None:
        """Integral and station learn from the step that ends."""
        memory, gains = self.memory, self.parameters.foothold
        if memory.ticks == 0:
            return
        mean, place = memory.velocity_sum / memory.ticks, memory.position_sum / memory.ticks
        if memory.settling == 0:
            error = np.clip(memory.gait.speed - 0.5 * (mean + memory.last_mean_velocity), -SLIP, SLIP)
            grown = memory.integral + np.array(gains.integral_gain) * error
            memory.integral = np.clip(grown, -gains.integral_limit, gains.integral_limit)
        memory.settling = max(memory.settling - 1, 0)
        if not memory.station_kept:
            memory.station = 0.5 * (place + memory.last_position)
        memory.last_mean_velocity, memory.last_position = mean, place
        memory.velocity_sum, memory.position_sum, memory.ticks = np.zeros(2), np.zeros(2), 0

    def _keep_station(self, requested: GaitNumbers) -> None:
        """A robot commanded to zero keeps its place once it is slow; any other command gives it up."""
        memory = self.memory
        if np.any(requested.speed != 0.0):
            memory.station_kept = False
        elif memory.step_count > 2 and abs(memory.last_mean_velocity[0]) < SETTLED and not memory.gait.speed.any():
            memory.station_kept = True

    def _may_rest(self, now: Instant) -> bool:
        """Slow, and the soles side by side."""
        entry = self.parameters.standing.entry_speed
        slow = abs(self.memory.last_mean_velocity[0]) < entry and abs(now.com_velocity[0]) < entry
        return slow and abs(now.offset(LEFT)[0, 0] - now.offset(RIGHT)[0, 0]) < STRADDLE

    # ---- where the soles go: eqs. 7-15 ---------------------------------------------------------------------------

    def _run_template(self, now: Instant) -> None:
        memory, gait, t = self.memory, self.memory.gait, self.memory.step_time
        stance, swing = memory.stance, 1 - memory.stance
        low = -gait.height
        start = memory.support_start[:, 2]
        height = curve(t, gait, start, start[0] + gait.alpha * (low - start[0]), low)
        support = np.vstack([now.offset(stance), np.zeros(3)])  # x and y follow the robot: nothing tracks them
        support[:, 2] = height
        memory.foot_desired[stance] = support

        memory.velocity_sum = memory.velocity_sum + now.com_velocity[:2]
        memory.position_sum = memory.position_sum + now.com.position[:2]
        memory.ticks += 1
        memory.foothold = self._foothold(now)

        landing = np.array([*memory.foothold, low])
        for axis in range(3):
            first = memory.swing_start[0, axis]
            middle = low + gait.lift if axis == 2 else 0.5 * (first + landing[axis])
            begin = np.array([first, memory.swing_start[1, axis], 0.0])
            memory.foot_desired[swing, :, axis] = curve(t, gait, begin, middle, landing[axis])
        if t > gait.period:
            descent = self.parameters.touchdown.descent_speed
            memory.foot_desired[swing, :2, 2] += [-descent * (t - gait.period), -descent]

    def _foothold(self, now: Instant) -> Array:
        """Eqs. 13 and 15, with forecast, integral, station, and bounds."""
        memory, gait, gains = self.memory, self.memory.gait, self.parameters.foothold
        arm = now.in_heading(now.com.position - now.soles[memory.stance].position)
        omega = np.sqrt(GRAVITY / max(arm[2], LOWEST_COM))
        duration = memory.duration_ratio * gait.period  # as steps really last
        rest = omega * max(duration - memory.step_time, 0.0)
        velocity = now.com_velocity[:2]
        forecast = np.cosh(rest) * velocity + omega * np.sinh(rest) * arm[:2]
        velocity = velocity + gains.prediction * (forecast - velocity)
        half = 0.5 * omega * duration
        reference = (1.0 + gains.mean_speed * (half / np.tanh(half) - 1.0)) * gait.speed
        acceleration = now.in_heading(now.com.jacobian[:3] @ memory.acceleration + now.com.bias[:3])[:2]

        share, gain = gains.mean_speed, np.array(gains.velocity_gain)
        gain = gain + gains.deadbeat * (1.0 / (omega * np.tanh(omega * duration)) - gain)
        length = (gait.period + share * (duration - gait.period)) * gait.speed
        target = 0.5 * length + share * now.in_heading(now.com.position - now.hip.position)[:2] - memory.integral
        target += gain * (velocity - reference) - gains.acceleration_gain * acceleration
        if memory.station_kept:
            drift = now.in_heading(np.array([*(now.com.position[:2] - memory.station), 0.0]))[:2]
            target += np.clip(np.array(gains.station_gain) * drift, -gains.station_limit, gains.station_limit)
        outward = 1.0 if memory.stance == RIGHT else -1.0
        beside = now.offset(memory.stance)[0, 1]
        lateral = np.clip(target[1] + outward * gait.width, -gains.spread, gains.spread)
        lateral = outward * max(outward * lateral, outward * beside + gains.separation)
        return np.array([np.clip(target[0], -gains.reach, gains.reach), lateral])

    # ---- inverse kinematics: eqs. 28-32 --------------------------------------------------------------------------

    def _track_leg(self, now: Instant, row: int) -> None:
        """One step of min ‖J Δq - (v + k e) dt‖² + Q2 ‖Δq‖² + Q3 ‖Δq - Δq_last‖² + Q4 ‖J_θ Δq - θ‖² within limits."""
        memory, gains, leg = self.memory, self.parameters.inverse_kinematics, self.robot.legs[row]
        own = leg.joint_indices
        low, high = self.robot.position_low[own], self.robot.position_high[own]
        reach = self.robot.velocity_limit[own] * DT
        reference = np.clip(memory.leg_reference[row], low, high)
        position, rotation, jacobian = self.body.leg_pose(leg, reference)
        to_torso = now.hip.rotation.T @ now.heading
        wanted, rate = to_torso @ memory.foot_desired[row, 0] + self.robot.hip_midpoint, memory.foot_desired[row, 1]
        travel = (to_torso @ rate + gains.gain * (wanted - position)) * DT
        axes = TURNS[len(own)]
        turn = self._turn(rotation, now.hip.rotation.T @ self._sole_target(now, row), axes)
        turning = (rotation.T @ jacobian[3:])[axes]
        last = memory.leg_rate[row] * DT
        hessian = jacobian[:3].T @ jacobian[:3] + gains.pitch_weight * turning.T @ turning
        hessian += (gains.step_weight + gains.change_weight) * np.eye(len(own))
        gradient = -jacobian[:3].T @ travel - gains.pitch_weight * turning.T @ turn - gains.change_weight * last
        step = minimise(
            hessian,
            gradient,
            np.maximum(low - reference, -reach),
            np.minimum(high - reference, reach),
            np.zeros((0, len(own))),
            np.zeros(0),
        )
        memory.leg_reference[row], memory.leg_rate[row] = np.clip(reference + step, low, high), step / DT

    def _sole_target(self, now: Instant, row: int) -> Array:
        """World rotation of a sole: as it is in stance; in swing level, its pitch fading over the lifting stage."""
        memory, gait = self.memory, self.memory.gait
        if row == memory.stance:
            return now.soles[row].rotation
        phase = min(memory.step_time / (gait.alpha * gait.period), 1.0)
        pitch = memory.swing_pitch_start * (1.0 - phase**2 * (3.0 - 2.0 * phase))
        c, s = np.cos(pitch), np.sin(pitch)
        return now.heading @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])

    @staticmethod
    def _turn(actual: Array, target: Array, axes: list[int]) -> Array:
        """Rotation from actual to target about the sole's controlled axes, rad."""
        relative = actual.T @ target
        if axes == [1]:
            return np.array([np.arctan2(-relative[2, 0], relative[0, 0])])
        quaternion, vector = np.zeros(4), np.zeros(3)
        mujoco.mju_mat2Quat(quaternion, relative.ravel())
        mujoco.mju_quat2Vel(vector, quaternion, 1.0)
        return vector[axes]

    # ---- what the whole body is asked for: eqs. 20-23 ------------------------------------------------------------

    def wishes(self, now: Instant, q: Array, v: Array) -> Wishes:
        """Targets of the whole-body QP."""
        memory, parameters, weights = self.memory, self.parameters, self.parameters.weights
        tracking, standing, others = parameters.tracking, parameters.standing, parameters.other_joints
        n = len(self.robot.joint_names)
        weight = np.full(n, weights.other_joint)
        acceleration = -others.stiffness * q[7:] - others.damping * v[6:]
        for row, leg in enumerate(self.robot.legs):
            own = leg.joint_indices
            error, rate_error = memory.leg_reference[row] - q[7 + own], memory.leg_rate[row] - v[6 + own]
            acceleration[own] = tracking.joint_stiffness * error + tracking.joint_damping * rate_error
            weight[own] = 0.0
            if memory.walking and row == memory.stance:
                weight[leg.knee] = weights.knee
            elif memory.walking:
                weight[own], weight[leg.ankle_pitch] = weights.swing_joint, weights.swing_ankle
        wishes = Wishes(acceleration, weight)
        if memory.walking:
            swing, ankle = 1 - memory.stance, parameters.ankle
            desired, actual = memory.foot_desired[swing], now.offset(swing)
            wishes.stance = (memory.stance,)
            wishes.swing_acceleration = (
                desired[2]
                + tracking.foot_stiffness * (desired[0] - actual[0])
                + tracking.foot_damping * (desired[1] - actual[1])
            )
            push = ankle.speed_gain * (now.com_velocity[0] - memory.gait.speed[0])
            wishes.ankle_torque = self.press[memory.stance] * float(
                np.clip(push, -ankle.torque_limit, ankle.torque_limit)
            )
            return wishes
        middle = 0.5 * (now.soles[LEFT].position + now.soles[RIGHT].position)
        rise = -0.5 * (now.offset(LEFT)[1, 2] + now.offset(RIGHT)[1, 2])
        error = now.in_heading(middle - now.com.position)
        error[2] = memory.standing_height - (now.hip.position - middle)[2]
        rate = np.array([*now.com_velocity[:2], rise])
        wishes.body_acceleration = standing.com_stiffness * error - standing.com_damping * rate
        return wishes

    def _joint_feedback(self, q: Array, v: Array) -> Array:
        """The PD of eq. 27: swing and stance gains, none while standing."""
        memory, gains = self.memory, self.joint_gains
        torque = np.zeros(len(self.robot.joint_names))
        if memory.walking:
            for row, leg in enumerate(self.robot.legs):
                kind = "stance" if row == memory.stance else "swing"
                stiffness, damping = (np.array(getattr(gains, f"{kind}_{name}")) for name in ("stiffness", "damping"))
                own = leg.joint_indices
                torque[own] = stiffness * (memory.leg_reference[row] - q[7 + own])
                torque[own] += damping * (memory.leg_rate[row] - v[6 + own])
        return torque
