"""What the controller remembers of its readings, channel by channel, to tell a bad one and to do without it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import IntVector, Vector
from gaitsmith.estimation.filters import EstimatorGains, EstimatorState
from gaitsmith.estimation.measurement import FARTHEST, FASTEST, STRONGEST, Measurement, all_of, make_measurement
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.reference import Reference

GOOD, MISSING, STUCK, JUMP, CONTRADICTION, HIGH, UNLOADED = range(7)
"""What can be wrong with a reading."""

WHAT = (
    "good",
    "not a number",
    "stuck",
    "implausible jump",
    "contradicts the other sensors",
    "force while the sole is high",
    "no force though the sole has landed",
)
POSITION, ATTITUDE, VELOCITY, ANGLES = range(4)
"""Channels; behind them each joint's angle, each joint's rate, accelerometer, gyro, each sole's force."""

_PATIENCE = 4.0  # 1/ω: how long the model alone may stand in for a reading
_ANGLE_PATIENCE = 1.6  # the same for a joint whose rate comes from its angle
_LONGEST_GAP = 0.4  # the same for ticks that do not come


class Readings(NamedTuple):
    """Memory between ticks; m channels, N entries, those of a :class:`Measurement` in its order.

    Attributes:
        values: (N,) the measurement, in one array.
        wanted: (N,) what the model says it should be, in one array.
        before: (N,) as read one tick ago.
        first: (m + 1,) entry at which each channel begins.
        bound: (m,) largest magnitude that is usable.
        gate: (m,) largest deviation from the model in one tick.
        slack: (m,) largest deviation of a reading that does not move any more.
        patience: (m,) ticks for which the model alone may stand in.
        read: (m,) 1 if the controller reads the channel.
        still: (m,) ticks for which a reading has not changed.
        lost: (m,) ticks for which a channel has been replaced; 0 for a good one.
        again: (m,) ticks for which a lost channel has looked good; 1 for a good one that has just jumped.
        blind: (m,) ticks for which the model alone has stood in.
        what: (m,) what is wrong, one of :data:`WHAT`.
        slope: (nv,) velocity by differences of positions, m/s and rad/s.
        valid: (nv,) 1 where both positions of a difference were good.
        error: (nv,) velocity by differences minus velocity as read, smoothed; with sensors alone, entries 0 to 2: the
            accelerometer minus gravity, smoothed, m/s²; 3 to 5: the attitude minus that turned by the gyro, rad.
        rate: (nj,) joint rates as the model goes on with them, rad/s.
        shift: (4,) rotation by which the attitude has jumped, taken off it since, torso axes.
        shifted: (1,) 1 while there is one.
        weak: (2,) motor that was named last, and ticks for which that is remembered.
        normal: (3,) ground's normal below the sole that stood last, world axes.
        odd: (n,) ticks for which a sole has been loaded high up, or unloaded though it has landed.
        landing_speed: (n,) speed of a sole when its force came, m/s.
        weight: (1,) of the robot, N.
        rate_unit: (1,) ω = √(g/z), 1/s.
        height_unit: (1,) z, m.
        changes: (1,) how many times something has become wrong or good again.
        culprit: (1,) channel that the robot cannot do without any longer, m for ticks that came too late, m + 1 for a
            torso that tilts or hips that sink too far, m + 2 + j for the same while motor j is weak; -1 for none.
        late: (1,) ticks missed just now.
        longest_gap: (1,) ticks that may be missed in a row.
        begun: (1,) 1 once anything has been read.
        moving: (1,) 1 if any reading but the soles' has changed.
        trusted: (1,) 1 in a tick that has no model to compare with: the first, a late one, one without torques,
            one of a robot that does not move.
    """

    values: Vector
    wanted: Vector
    before: Vector
    first: IntVector
    bound: Vector
    gate: Vector
    slack: Vector
    patience: Vector
    read: IntVector
    still: IntVector
    lost: IntVector
    again: IntVector
    blind: IntVector
    what: IntVector
    slope: Vector
    valid: IntVector
    error: Vector
    rate: Vector
    shift: Vector
    shifted: IntVector
    weak: IntVector
    normal: Vector
    odd: IntVector
    landing_speed: Vector
    weight: Vector
    rate_unit: Vector
    height_unit: Vector
    changes: IntVector
    culprit: IntVector
    late: IntVector
    longest_gap: IntVector
    begun: IntVector
    moving: IntVector
    trusted: IntVector


class Checking(NamedTuple):
    """What the check of the readings reads and writes.

    Attributes:
        body: the robot as the last tick saw it.
        measurement: of this tick; bad readings are replaced in it.
        expected: the same as the model says it should be, over ``readings.wanted``.
        readings: memory.
        reference: of the last tick.
        acceleration: (nv,) that the last whole-body solution predicted.
        gains: of the estimator.
        state: of the estimator.
    """

    body: Body
    measurement: Measurement
    expected: Measurement
    readings: Readings
    reference: Reference
    acceleration: Vector
    gains: EstimatorGains
    state: EstimatorState


def channel_names(joints: tuple[str, ...], soles: tuple[str, ...]) -> tuple[str, ...]:
    """Names of all channels, as faults and telemetry call them."""
    return (
        *("base_position", "attitude", "base_velocity"),
        *(f"{joint}.angle" for joint in joints),
        *(f"{joint}.rate" for joint in joints),
        *("accelerometer", "gyro"),
        *(f"{sole}.force" for sole in soles),
    )


def make_readings(
    measurement: Measurement, estimated: bool, weight: float, rate: float, height: float, dt: float
) -> tuple[Readings, Measurement]:
    """Memory that has seen nothing, and the measurement that the model expects, over it.

    Args:
        measurement: of the controller.
        estimated: whether the state is estimated from sensors.
        weight: of the robot, N.
        rate: ω = √(g/z), 1/s.
        height: z of its centre of mass, m.
        dt: control period, s.
    """
    nj, n = len(measurement.joint_position), len(measurement.sole_force)
    expected = make_measurement(nj, n)
    sizes = [3, 4, 6, *[1] * (2 * nj), 3, 3, *[1] * n]
    groups = [1, 1, 1, nj, nj, 1, 1, n]
    speed, spread = rate * height, np.repeat

    def of(*values: float) -> npt.NDArray[np.float64]:
        """One number a sensor, for its channels."""
        return spread(np.array(values, dtype=np.float64), groups)

    m = len(sizes)
    whole = {name: np.zeros(m, dtype=np.int64) for name in ("still", "lost", "again", "blind", "what")}
    read = of(0, 1, 0, 1, 0, 1, 1, 1) if estimated else of(1, 1, 1, 1, 1, 0, 0, 1)
    patience, own = round(_PATIENCE / rate / dt), round(_ANGLE_PATIENCE / rate / dt)
    return Readings(
        values=all_of(measurement),
        wanted=all_of(expected),
        before=np.zeros(sum(sizes)),
        first=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        bound=of(FARTHEST, 2.0, FASTEST, FASTEST, 10.0 * FASTEST, STRONGEST, FASTEST, STRONGEST),
        gate=of(0.05 * height, 0.03, speed, 0.02, 20.0 * rate, math.inf, 0.3 * rate, math.inf),
        slack=of(0.02 * height, 0.01, 0.05 * speed, 0.01, 0.15 * rate, 0.5, 0.1 * rate, math.inf),
        patience=spread(np.array([patience] * 3 + [own if estimated else patience] + [patience] * 4), groups),
        read=read.astype(np.int64),
        **whole,
        slope=np.zeros(6 + nj),
        valid=np.zeros(6 + nj, dtype=np.int64),
        error=np.zeros(6 + nj),
        rate=np.zeros(nj),
        shift=np.array([1.0, 0.0, 0.0, 0.0]),
        weak=np.zeros(2, dtype=np.int64),
        normal=np.array([0.0, 0.0, 1.0]),
        odd=np.zeros(n, dtype=np.int64),
        landing_speed=np.zeros(n),
        weight=np.array([weight]),
        rate_unit=np.array([rate]),
        height_unit=np.array([height]),
        changes=np.zeros(1, dtype=np.int64),
        culprit=np.array([-1]),
        longest_gap=np.array([round(_LONGEST_GAP / rate / dt)]),
        **{name: np.zeros(1, dtype=np.int64) for name in ("shifted", "late", "begun", "moving", "trusted")},
    ), expected
