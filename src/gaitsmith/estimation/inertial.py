"""Attitude, accelerometer and gyro of a robot that has nothing else, against each other."""

from __future__ import annotations

import math

from gaitsmith.compiled import kernel
from gaitsmith.dynamics.rotation import turn_quaternion
from gaitsmith.estimation.channel import judge, judge_attitude, settle
from gaitsmith.estimation.readings import ANGLES, ATTITUDE, CONTRADICTION, GOOD, JUMP, MISSING, Checking

_GYRO_TIME = 0.02  # s, smoothing of the attitude's error
_ATTITUDE_ERROR = 0.03  # rad, smoothed, that a gyro may turn away from the attitude
_TURN_GAIN, _RATE_GAIN = 50.0, 625.0  # 1/s, 1/s²: of the attitude's error on attitude and rate without a gyro
_PULL_TIME = 0.3  # s, smoothing of the accelerometer's difference from gravity
_SUSPECT = 0.4  # of these errors for the rest of an IMU whose attitude has jumped
_RETAKE = 20  # ticks after which an attitude that has jumped, and not gone on, is taken anew
_PULL_ERROR = 0.45  # g, smoothed, by which it may differ; half of that to be good again


@kernel
def _check_accelerometer(g: Checking, c: int, dt: float) -> None:
    """The accelerometer against gravity: over a time no walk accelerates by much."""
    r, what, size, g2 = g.readings, judge(g.readings, c, dt), 0.0, 0.0
    for i in range(3):
        off = r.before[r.first[c] + i] - g.expected.accelerometer[i]
        if what != MISSING:
            r.error[i] += dt / _PULL_TIME * (off - r.error[i])
        size += r.error[i] ** 2
        g2 += g.body.tree.gravity[i] ** 2
    limit = _PULL_ERROR * (_SUSPECT if r.shifted[0] == 1 else (1.0 if r.lost[c] == 0 else 0.5))
    if what == GOOD and size > limit * limit * g2:
        what = CONTRADICTION
    settle(r, c, what, True)


@kernel
def unshift_attitude(g: Checking) -> None:
    """The attitude without the jump that it once made."""
    q, s = g.measurement.base_quaternion, g.readings.shift
    w, x, y, z = q[0], q[1], q[2], q[3]
    q[0] = w * s[0] + x * s[1] + y * s[2] + z * s[3]
    q[1] = x * s[0] - w * s[1] - y * s[3] + z * s[2]
    q[2] = y * s[0] - w * s[2] - z * s[1] + x * s[3]
    q[3] = z * s[0] - w * s[3] - x * s[2] + y * s[1]


@kernel
def _take_jump(g: Checking, known: bool) -> bool:
    """An attitude that has jumped goes on from what is expected, if that is known; True for one that has come back.

    A mount that slips turns every reading by the same rotation s: as read, R s = R_expected s' with s' of this tick.
    """
    r, q, p, s = g.readings, g.measurement.base_quaternion, g.expected.base_quaternion, g.readings.shift
    w = q[0] * s[0] - q[1] * s[1] - q[2] * s[2] - q[3] * s[3]
    x = q[0] * s[1] + q[1] * s[0] + q[2] * s[3] - q[3] * s[2]
    y = q[0] * s[2] + q[2] * s[0] + q[3] * s[1] - q[1] * s[3]
    z = q[0] * s[3] + q[3] * s[0] + q[1] * s[2] - q[2] * s[1]
    size = math.sqrt(w * w + x * x + y * y + z * z)
    a = (p[0] * w + p[1] * x + p[2] * y + p[3] * z) / size
    b = (p[0] * x - p[1] * w - p[2] * z + p[3] * y) / size
    c = (p[0] * y - p[2] * w - p[3] * x + p[1] * z) / size
    d = (p[0] * z - p[3] * w - p[1] * y + p[2] * x) / size
    back = max(abs(b), abs(c), abs(d)) < r.gate[ATTITUDE]
    if back or (known and (r.what[ATTITUDE] == GOOD or r.lost[ATTITUDE] % _RETAKE == 0)):
        s[0], s[1], s[2], s[3] = (1.0, 0.0, 0.0, 0.0) if back else (a, b, c, d)
        r.shifted[0] = 0 if back else 1
    return bool(back)


@kernel
def check_inertial(g: Checking, dt: float) -> None:
    """Attitude, accelerometer and gyro of a robot that has nothing else."""
    r, q, p = g.readings, g.measurement.base_quaternion, g.expected.base_quaternion
    accelerometer = ANGLES + 2 * r.rate.shape[0]
    gyro = accelerometer + 1
    _check_accelerometer(g, accelerometer, dt)
    what = judge_attitude(g, dt)
    known = r.lost[gyro] == 0
    if what == JUMP and not _take_jump(g, known) and not known:  # without a gyro it is the attitude that counts
        what = GOOD
    off = (
        2.0 * (p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2]),
        2.0 * (p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1]),
        2.0 * (p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0]),
    )
    settle(r, ATTITUDE, what, known)
    what, worst, known = judge(r, gyro, dt), 0.0, r.lost[ATTITUDE] == 0
    for i in range(3):
        r.error[3 + i] += dt / _GYRO_TIME * ((off[i] if known else 0.0) - r.error[3 + i])
        worst = max(worst, abs(r.error[3 + i]))
    if what == GOOD and worst > _ATTITUDE_ERROR * (_SUSPECT if r.shifted[0] == 1 else 1.0):
        what = CONTRADICTION
    if (what != GOOD or r.lost[gyro] > 0) and known:
        share = dt * _TURN_GAIN
        turn_quaternion(g.state.quaternion, share * off[0], share * off[1], share * off[2])
        for i in range(3):
            for k in range(3):
                g.expected.gyro[i] += dt * _RATE_GAIN * g.gains.imu_rotation[k, i] * off[k]
    settle(r, gyro, what, known)
