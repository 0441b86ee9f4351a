"""Every reading against what the model expects, before the tick uses it; a bad one is replaced, never let through.

A channel is bad if it is no number that a robot can produce, if it does not move while the model moves, if it jumps
farther than any joint or body can go in one tick, or if it contradicts the others: a rate that is not the slope of its
angle, a gyro that turns away from the attitude, a sole that is loaded high up in its swing. It is replaced by what the
rest says: a rate by the slope of its angle, an angle by its rate, a joint of the standing leg by the ground that its
sole lies on, a sole's force by kinematics and the step's clock; where nothing says it, by the acceleration of the last
whole-body solution, and only for a time.
"""

from __future__ import annotations

import math

from gaitsmith.compiled import IntVector, kernel
from gaitsmith.dynamics.rotation import turn_quaternion
from gaitsmith.estimation.channel import is_valid, judge, judge_attitude, passes, settle
from gaitsmith.estimation.inertial import check_inertial, unshift_attitude
from gaitsmith.estimation.readings import (
    ANGLES,
    ATTITUDE,
    CONTRADICTION,
    GOOD,
    JUMP,
    POSITION,
    VELOCITY,
    Checking,
    Readings,
)
from gaitsmith.estimation.sole_force import check_force
from gaitsmith.whole_body.reference import NONE

_FALLEN = (0.9, 0.43)  # rad of tilt, share of its height by which it has sunk: beyond, no torque brings it back
_FALLING = (0.7, 0.4)  # the same while a motor is weak
_SHARE = 0.2  # of a new difference in the smoothed one
_RATE_ERROR = 0.15  # ω, smoothed, that a joint's rate may differ from its angle's slope
_STRUCK = (0.5, 4.0)  # of the gate: by which a joint that was struck leaves the model behind in every tick
_SOLE_GAIN = 0.1  # of the sole's tilt on the angle that stands in for a joint of the standing leg, per tick


@kernel
def _difference(r: Readings, g: Checking, over: float) -> None:
    """Velocities by differences of positions; whether anything moves; ``over``: 1 by the time since the last tick."""
    before, m = r.before, g.measurement
    r.moving[0] = 0
    for c in range(r.read.shape[0] - m.sole_force.shape[0] - 1, -1, -1):
        for i in range(r.first[c], r.first[c + 1] if r.read[c] == 1 else r.first[c]):
            r.moving[0] = 1 if r.values[i] != before[i] else r.moving[0]
        if r.moving[0] == 1:
            break
    for i in range(3):
        r.slope[i] = (m.base_position[i] - before[i]) * over
    q, w, x, y, z = m.base_quaternion, before[3], before[4], before[5], before[6]
    sign = 2.0 * over if w * q[0] + x * q[1] + y * q[2] + z * q[3] >= 0.0 else -2.0 * over
    r.slope[3] = sign * (w * q[1] - x * q[0] - y * q[3] + z * q[2])
    r.slope[4] = sign * (w * q[2] + x * q[3] - y * q[0] - z * q[1])
    r.slope[5] = sign * (w * q[3] - x * q[2] + y * q[1] - z * q[0])
    for j in range(m.joint_position.shape[0]):
        r.slope[6 + j] = (m.joint_position[j] - before[13 + j]) * over


@kernel
def _expect(g: Checking, dt: float, estimated: bool, driven: bool) -> None:
    """What every reading should be by the state and the acceleration of the tick before."""
    r, e, v, a, state = g.readings, g.expected, g.body.v, g.acceleration, g.state
    share, nj = dt if driven else 0.0, r.rate.shape[0]
    if not estimated:
        for i in range(3):
            e.base_position[i] += dt * v[i]
        turn_quaternion(e.base_quaternion, dt * v[3], dt * v[4], dt * v[5])
        for i in range(6):
            e.base_velocity[i] += share * a[i]
        for j in range(nj):
            e.joint_position[j] += dt * v[6 + j]
            e.joint_velocity[j] += share * a[6 + j]
        return
    spin, axes, gravity = state.angular_velocity, g.body.state.body_rotation[g.body.legs.torso[0]], g.body.tree.gravity
    for i in range(4):
        e.base_quaternion[i] = state.quaternion[i]
    turn_quaternion(e.base_quaternion, dt * spin[0], dt * spin[1], dt * spin[2])
    for i in range(3):
        turning = pull = 0.0
        for k in range(3):
            turning += g.gains.imu_rotation[k, i] * a[3 + k]
            down = axes[0, k] * gravity[0] + axes[1, k] * gravity[1] + axes[2, k] * gravity[2]
            pull -= g.gains.imu_rotation[k, i] * down
        e.gyro[i] += share * turning
        e.accelerometer[i] = pull
    for j in range(nj):
        if r.lost[ANGLES + j] == 0 and (r.still[ANGLES + j] == 0 or r.trusted[0] == 1):
            r.rate[j] += _SHARE * (v[6 + j] - r.rate[j])
        r.rate[j] += share * a[6 + j]
        e.joint_position[j] += dt * r.rate[j]


@kernel
def _rests_on(g: Checking, leg: int) -> bool:
    """Whether a leg's sole is planned to stand, and all joints of the leg but one are known."""
    lost, joints = 0, g.body.legs.joints
    for i in range(joints.shape[1]):
        lost += 1 if g.readings.lost[ANGLES + joints[leg, i]] > 0 else 0
    return bool(g.reference.contact[leg] != NONE and lost == 1)


@kernel
def _lay_sole_flat(g: Checking, leg: int, joint: int) -> bool:
    """Turn a joint of which nothing is known so that its standing sole lies on the ground; False if it cannot."""
    frames, r, legs = g.body.frames, g.readings, g.body.legs
    sole, up, jacobian = frames.sole_rotation[leg], r.normal, frames.sole_jacobian[leg]
    line = legs.half_width[leg] == 0.0
    size = turn = 0.0
    for i in range(3):
        k, m = (i + 1) % 3, (i + 2) % 3
        error = sole[k, 2] * up[m] - sole[m, 2] * up[k]
        axis = jacobian[3 + i, 6 + joint]
        size += axis * axis
        turn += axis * error
    across = 0.0
    for i in range(3):
        across += jacobian[3 + i, 6 + joint] * (sole[i, 1] if line else sole[i, 2])
    free = abs(across) < 0.7 if line else abs(across) > 0.7
    if free or size < 0.5:
        return False
    r.wanted[r.first[ANGLES + joint]] += _SOLE_GAIN * turn / size
    return True


@kernel
def _is_struck(g: Checking, j: int, dt: float, estimated: bool) -> bool:
    """Whether a joint that jumped is waited for, or moves on as fast: then it was struck, and its encoder is good.

    A joint that a foot's impact sets in motion leaves the model behind by a step in every tick; an encoder that breaks
    does so once. The angle of the first tick is the model's.
    """
    r, c, state = g.readings, ANGLES + j, g.state
    place, slope = r.first[c], r.slope[6 + j]
    rate = r.rate[j] if estimated else g.body.v[6 + j]
    beyond = dt * (slope - rate)
    if r.again[c] == 0:
        r.again[c] = 1
        state.joint_previous[j] = r.wanted[place] - dt * rate
        r.values[place] = r.wanted[place]
        return True
    off = r.values[place] - r.wanted[place]
    if off * beyond <= 0.0 or not _STRUCK[0] < abs(beyond) / r.gate[c] < _STRUCK[1]:
        return False
    r.again[c] = 0
    r.rate[j] = state.joint_velocity[j] = slope
    state.joint_previous[j] = r.values[place] - dt * slope
    r.wanted[place] = r.values[place]
    return True


@kernel
def _check_angles(g: Checking, dt: float, estimated: bool) -> None:
    """Joint angles: by their rates, or, with sensors alone, by the sole that the leg stands on."""
    r, legs = g.readings, g.body.legs
    for j in range(r.rate.shape[0]):
        c = ANGLES + j
        if passes(r, c):
            r.valid[6 + j] = 2 * (1 - r.trusted[0])
            continue
        was, place = r.lost[c] + r.again[c], r.first[c]
        what, seen = judge(r, c, dt), not estimated and r.lost[c + r.rate.shape[0]] == 0
        if what == JUMP and r.what[c] == GOOD and _is_struck(g, j, dt, estimated):
            r.valid[6 + j] = 0
            continue
        leg = legs.leg_of_joint[j]
        if estimated and r.lost[c] > 0 and leg >= 0 and _rests_on(g, leg):
            seen = _lay_sole_flat(g, leg, j)
        settle(r, c, what, seen)
        if (was > 0) != (r.lost[c] > 0):  # no rate is to be read from the way to what stands in, or back
            g.state.joint_previous[j] = r.values[place] - dt * r.rate[j]
            if was == 0:
                g.state.joint_velocity[j] = r.rate[j]
        r.valid[6 + j] = is_valid(r, c, was)


@kernel
def _check_velocity(g: Checking, c: int, first: int, last: int, dt: float) -> None:
    """A channel of velocities, entries ``first`` to ``last`` of v, against the slopes of its positions."""
    r, place, seen, worst = g.readings, int(g.readings.first[c]) - first, True, 0.0
    for k in range(first, last):
        off, now, before, slope = 0.0, r.values[place + k], r.before[place + k], r.slope[k]
        if r.valid[k] == 2:
            low, high = min(now, before), max(now, before)
            off = slope - high if slope > high else min(slope - low, 0.0)
        seen = seen and r.valid[k] > 0
        r.error[k] = _SHARE * off + (1.0 - _SHARE) * r.error[k] if abs(off) < math.inf else 0.0
        worst = max(worst, abs(r.error[k]) / (0.3 * r.height_unit[0] if k < 3 else 1.0))
    contradicts = worst > _RATE_ERROR * r.rate_unit[0]
    if not contradicts and passes(r, c):
        return
    what = judge(r, c, dt)
    if what == GOOD and contradicts:
        what = CONTRADICTION
    if what != GOOD or r.lost[c] > 0:
        for k in range(first, last):
            r.wanted[place + k] = r.slope[k] if r.valid[k] > 0 else r.wanted[place + k]
    settle(r, c, what, seen)


@kernel
def _lost_balance(g: Checking, sunk: float, weak: IntVector) -> int:
    """0 while torques may bring the robot back; else 1, or 2 + j if motor j was weak lately: then it ends earlier."""
    r, tilt = g.readings, g.body.frames.tilt
    r.weak[1] = max(r.weak[1] - 1, 0)
    for j in range(weak.shape[0]):
        if weak[j] == 1:
            r.weak[0], r.weak[1] = j, r.patience[POSITION]
    tilted, low = _FALLING if r.weak[1] > 0 else _FALLEN
    if max(abs(tilt[0]), abs(tilt[1])) > tilted or sunk > low:
        return 2 + r.weak[0] if r.weak[1] > 0 else 1
    return 0


@kernel
def check_readings(
    g: Checking,
    dt: float,
    estimated: bool,
    driven: bool,
    swing: int,
    time: float,
    period: float,
    earliest: float,
    least: float,
    sunk: float,
    weak: IntVector,
) -> int:
    """Check every reading of this tick and, where needed, replace it.

    Args:
        g: everything.
        dt: s.
        estimated: whether the state comes from sensors alone.
        driven: whether the last tick's torques were those of the whole-body solution.
        swing: leg in the air, -1 on both feet.
        time: since the step began, s.
        period: of the step, s.
        earliest: before which no sole lands, s.
        least: force that counts as contact, N.
        sunk: share of its height by which the robot is too low.
        weak: (nj,) 1 for a motor that gives less than it is told.

    Returns:
        The channel that the robot cannot do without any longer; -1 if there is none.
    """
    r = g.readings
    nj, elapsed = r.rate.shape[0], dt * (1 + r.late[0])
    first = r.begun[0] == 0
    r.begun[0] = 1
    if r.shifted[0] == 1 and estimated:
        unshift_attitude(g)
    _difference(r, g, 1.0 / elapsed)
    r.trusted[0] = 1 if r.late[0] > 0 or first or not driven or r.moving[0] == 0 else 0
    _expect(g, elapsed, estimated, driven)
    if not estimated:
        lost = (r.lost[POSITION], r.lost[ATTITUDE])
        if not passes(r, POSITION):
            settle(r, POSITION, judge(r, POSITION, dt), r.lost[VELOCITY] == 0)
        settle(r, ATTITUDE, judge_attitude(g, dt), r.lost[VELOCITY] == 0)
        for k in range(3):
            r.valid[k] = is_valid(r, POSITION, lost[0])
            r.valid[3 + k] = is_valid(r, ATTITUDE, lost[1])
    _check_angles(g, dt, estimated)
    if estimated:
        check_inertial(g, dt)
    else:
        _check_velocity(g, VELOCITY, 0, 6, dt)
        for j in range(nj):
            _check_velocity(g, ANGLES + nj + j, 6 + j, 7 + j, dt)
    for leg in range(g.body.frames.sole_position.shape[0]):
        check_force(g, leg, swing, time, period, earliest, least)
        if leg != swing and g.reference.contact[leg] != NONE and not _rests_on(g, leg):
            for i in range(3):
                r.normal[i] = g.body.frames.sole_rotation[leg, i, 2]
    beyond = _lost_balance(g, sunk, weak) if driven else 0
    if r.late[0] > r.longest_gap[0]:
        r.culprit[0] = r.what.shape[0]
    elif beyond > 0 and r.culprit[0] < 0:
        r.culprit[0] = r.what.shape[0] + beyond
    elif beyond == 0 and r.culprit[0] >= r.what.shape[0]:
        r.culprit[0] = -1
    return int(r.culprit[0])
