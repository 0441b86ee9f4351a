from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys
from tests.control.synthetic_walk import DT, IDEAL, Sensors, Walk, synthetic_walk

from gaitsmith.compiled import Arena, IntVector, Matrix, Vector, kernel
from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.estimation.estimator import (
    Estimation,
    EstimatorGains,
    EstimatorState,
    estimate,
    make_estimator_gains,
    make_estimator_state,
)
from gaitsmith.estimation.measurement import Measurement, make_measurement
from gaitsmith.whole_body.frames import Body, make_body

CONTACT_FORCE = 30.0  # N
LEVEL, SLOPE = (4.0, 0.4, 0.0), (1.6, 0.4, 0.04)  # duration, speed, climb a stride
SETTLED = 1000  # ticks, after the filters started at a wrong speed of .56 m/s

MEAN_SPEED = 1.5e-3  # m/s; a tenth of what the closed loop may be wrong by
SPEED = 8e-3  # m/s rms; half of it is the 2 ms by which filtered rates come late
ATTITUDE = 6e-4  # rad rms; the steady Kalman variance is (3.2e-4 rad)², plus the gyro's sampling
SPIN = 0.02  # rad/s rms; noise .009 and .01 of delay in pitch
RATES = 0.2  # rad/s rms; differences of an encoder with 3e-4 rad at 1 kHz are .42
BIAS = 0.04  # m/s² after 4 s; the filter's own deviation is then .03
HEIGHT = 1.5e-3  # m rms about a constant


class Estimate(NamedTuple):
    """What the estimator said, one row a tick, and the bias that it had to find (world axes at zero attitude)."""

    q: Matrix
    v: Matrix
    bias: Matrix
    velocity_variance: Matrix
    true_bias: Vector


class Setup(NamedTuple):
    """Arguments of one estimator."""

    walk: Walk
    body: Body
    gains: EstimatorGains
    state: EstimatorState
    measurement: Measurement

    def __call__(self, q: Vector, v: Vector, planned: IntVector) -> None:
        estimate(Arena(self.estimation()), DT, planned)
        q[:], v[:] = self.body.q, self.body.v

    def estimation(self) -> Estimation:
        """What the kernel reads and writes."""
        return Estimation(self.body, self.measurement, self.gains, self.state)


def _setup(walk: Walk) -> Setup:
    nj = walk.q.shape[1] - 7
    gains = make_estimator_gains(
        preset_parameters(walk.robot, robot_scale(walk.robot), "default").estimator,
        walk.robot.imu_position,
        CONTACT_FORCE,
        9.81 * walk.tree.total_mass,
    )
    measurement = make_measurement(nj)
    for unread in (measurement.base_position, measurement.base_velocity, measurement.joint_velocity):
        unread[:] = np.nan
    return Setup(walk, make_body(walk.tree, walk.legs), gains, make_estimator_state(nj), measurement)


def _sense(measurement: Measurement, walk: Walk, k: int, sensors: Sensors, bias: Vector, rng) -> None:
    x, y, z = 0.5 * sensors.attitude * rng.normal(size=3)
    w0, x0, y0, z0 = walk.q[k, 3:7]
    measurement.base_quaternion[:] = (
        w0 - x0 * x - y0 * y - z0 * z,
        x0 + w0 * x + y0 * z - z0 * y,
        y0 + w0 * y + z0 * x - x0 * z,
        z0 + w0 * z + x0 * y - y0 * x,
    )
    angles = walk.q[k, 7:] + sensors.encoder * rng.normal(size=walk.q.shape[1] - 7)
    measurement.joint_position[:] = np.round(angles / sensors.step) * sensors.step if sensors.step else angles
    measurement.accelerometer[:] = walk.accelerometer[k] + sensors.accelerometer * rng.normal(size=3) + bias
    measurement.gyro[:] = walk.gyro[k] + sensors.gyro * rng.normal(size=3)
    measurement.sole_force[:] = walk.sole_force[k]


@functools.cache
def _run(case: tuple[float, float, float], sensors: Sensors, seed: int) -> Estimate:
    walk = synthetic_walk(*case)
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=3)
    true_bias = sensors.bias * direction / np.linalg.norm(direction)
    setup = _setup(walk)
    shape = (len(walk.q), 3)
    found = Estimate(np.zeros_like(walk.q), np.zeros_like(walk.v), np.zeros(shape), np.zeros(shape), true_bias)
    both = np.ones(2, dtype=np.int64)
    for k in range(len(walk.q)):
        _sense(setup.measurement, walk, k, sensors, true_bias, rng)
        setup(found.q[k], found.v[k], both)
        found.bias[k], found.velocity_variance[k] = setup.state.motion[:, 2], setup.state.covariance[:, 3]
    return found


def _rms(values: Matrix) -> Vector:
    return np.sqrt(np.mean(values[SETTLED:] ** 2, axis=0))


@pytest.mark.parametrize(("sensors", "seed"), [(IDEAL, 0), (Sensors(), 1), (Sensors(), 2)])
def test_errors_on_a_known_walk(sensors, seed):
    walk, found = synthetic_walk(*LEVEL), _run(LEVEL, sensors, seed)
    error = found.v - walk.v
    assert np.max(np.abs(np.mean(error[SETTLED:, :3], axis=0))) < MEAN_SPEED
    assert np.max(_rms(error[:, :3])) < SPEED
    assert np.max(_rms(error[:, 3:6])) < SPIN
    assert np.max(_rms(error[:, 6:])) < RATES
    assert 2.0 * np.max(_rms(found.q[:, 3:7] - walk.q[:, 3:7])) < ATTITUDE
    assert np.max(np.abs(found.bias[-1] - found.true_bias)) < BIAS
    height = found.q[SETTLED:, 2] - walk.q[SETTLED:, 2]
    assert np.std(height) < HEIGHT


def test_drift_is_centimetres_per_hundred_metres_at_most():
    walk, found = synthetic_walk(*LEVEL), _run(LEVEL, Sensors(), 1)
    walked, said = (x.q[-1, :2] - x.q[SETTLED, :2] for x in (walk, found))
    assert np.max(np.abs(said - walked)) < 5e-3


def test_the_filter_knows_its_own_error():
    """Squared velocity error over variance: below 1 on average, as R is set for worse, but not absurdly below."""
    ratios = []
    for seed in (1, 2):
        walk, found = synthetic_walk(*LEVEL), _run(LEVEL, Sensors(), seed)
        lever = np.cross(walk.v[:, 3:6] - found.v[:, 3:6], walk.robot.imu_position)
        error = found.v[:, :3] - walk.v[:, :3] - lever
        ratios.append(np.mean(error[SETTLED:] ** 2 / found.velocity_variance[SETTLED:], axis=0))
    assert np.all(np.mean(ratios, axis=0) < 1.5)
    assert np.all(np.mean(ratios, axis=0) > 0.01)


def test_the_ground_may_rise():
    walk, found = synthetic_walk(*SLOPE), _run(SLOPE, Sensors(), 1)
    assert walk.q[-1, 2] - walk.q[0, 2] > 0.05
    assert np.std((found.q - walk.q)[SETTLED:, 2]) < HEIGHT
    assert np.max(_rms((found.v - walk.v)[:, :3])) < SPEED


@pytest.mark.parametrize("planned", [0, 1])
def test_without_contact_only_the_accelerometer_speaks(planned):
    walk = synthetic_walk(*SLOPE)
    setup = _setup(walk)
    q, v = np.zeros(walk.q.shape[1]), np.zeros(walk.v.shape[1])
    rng = np.random.default_rng(0)
    speeds, variances = [], []
    for _ in range(101):
        _sense(setup.measurement, walk, 0, IDEAL, np.zeros(3), rng)
        setup.measurement.accelerometer[:] = 0.0
        setup.measurement.gyro[:] = 0.0
        setup.measurement.sole_force[:] = CONTACT_FORCE - 1.0 if planned else 400.0
        setup(q, v, np.full(2, planned))
        speeds.append(v[:3].copy())
        variances.append(setup.state.covariance[:, 3].copy())
    np.testing.assert_allclose(speeds[-1] - speeds[0], 100 * DT * walk.tree.gravity, rtol=1e-9, atol=1e-9)
    assert np.all(np.diff(variances, axis=0)[1:] > 0.0)


def test_a_sole_that_has_just_landed_is_trusted_only_once_it_has_settled():
    walk = synthetic_walk(*SLOPE)
    setup, rng = _setup(walk), np.random.default_rng(0)
    q, v, both = np.zeros(walk.q.shape[1]), np.zeros(walk.v.shape[1]), np.ones(2, dtype=np.int64)
    air, tail = 20, 30
    unheard = round(setup.gains.settling / DT) - 1  # the tick at which the time is full counts as settled
    assert unheard >= 5
    variances = []
    for k in range(50 + air + unheard + tail):
        _sense(setup.measurement, walk, 0, IDEAL, np.zeros(3), rng)
        setup.measurement.sole_force[:] = 0.0 if 50 <= k < 50 + air else 400.0
        setup(q, v, both)
        variances.append(setup.state.covariance[:, 3].copy())
    rises = np.diff(variances, axis=0)[49:] > 0.0
    assert rises[: air + unheard].all()
    assert not rises[air + unheard].any()


def test_opposite_quaternions_mean_the_same():
    walk = synthetic_walk(*SLOPE)
    results = []
    for sign in (1.0, -1.0):
        setup, rng = _setup(walk), np.random.default_rng(0)
        q, v = np.zeros(walk.q.shape[1]), np.zeros(walk.v.shape[1])
        for k in range(5):
            _sense(setup.measurement, walk, k, Sensors(), np.zeros(3), rng)
            setup.measurement.base_quaternion[:] *= sign if k % 2 else 1.0
            setup(q, v, np.ones(2, dtype=np.int64))
        results.append(np.concatenate([q, v]))
    np.testing.assert_allclose(results[0], results[1], rtol=1e-12, atol=1e-12)


class Call(NamedTuple):
    """What the allocation test passes besides."""

    planned: IntVector


class Bound(NamedTuple):
    """All that the allocation test binds."""

    estimation: Estimation
    work: Call


@kernel
def call(g: Bound, times: int) -> None:
    for _ in range(times):
        estimate(g.estimation, 1e-3, g.work.planned)


def test_allocates_nothing():
    walk = synthetic_walk(*SLOPE)
    setup = _setup(walk)
    _sense(setup.measurement, walk, 0, IDEAL, np.zeros(3), np.random.default_rng(0))
    arena = Arena(Bound(setup.estimation(), Call(np.ones(2, dtype=np.int64))))
    call(arena, 1)
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    call(arena, 1000)
    assert rtsys.get_allocation_stats() == before
